"""What the nearest points of each point say about the surface there: normal, variation, spacing, rim."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.frames import tangents
from lpcompare.geometry.planes import fit_planes
from lpcompare.types import Mask, Points, Vector
from lpcompare_baselines._buckets import farthest_points

IndexArray = NDArray[np.intp]

_BLOCK = 32768
_WIDEST_GAP = np.pi / 2
"""Angle without a neighbour, in radians, from which a point lies on the rim of an open surface."""


def normals_and_variation(points: Points, neighbors: IndexArray) -> tuple[Points, Vector]:
    """Normal of each point's neighborhood, itself included, and its surface variation.

    Pauly, Gross and Kobbelt 2002, eqs. 1 to 5: the eigenvector of the least eigenvalue of the covariance, and
    that eigenvalue over the sum of all three.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    neighbors : ndarray of int, shape (n, k)
        The other points of each neighborhood.

    Returns
    -------
    normals : ndarray, shape (n, 3)
        Unit length, the sign is arbitrary.
    variation : ndarray, shape (n,)
        From 0 (flat) to 1/3; 0 where all points coincide.
    """
    normals, variation = np.empty_like(points), np.zeros(len(points))
    for start in range(0, len(points), _BLOCK):
        block = slice(start, start + _BLOCK)
        # relative to the point itself, so that large coordinates cost no digits
        offsets = points[neighbors[block]] - points[block, None]
        total = offsets.sum(axis=1)
        covariances = np.einsum("qki,qkj->qij", offsets, offsets, optimize=True)
        covariances -= total[:, :, None] * total[:, None, :] / (neighbors.shape[1] + 1)
        values, vectors = np.linalg.eigh(covariances)
        normals[block] = vectors[:, :, 0]
        whole = values.sum(axis=1)
        np.divide(np.maximum(values[:, 0], 0.0), whole, out=variation[block], where=whole > 0)
    return normals, variation


def planes_and_variation(points: Points, hoods: IndexArray) -> tuple[Points, Vector]:
    """Normal of the plane through each neighborhood, and the share of its variance that lies along it.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    hoods : ndarray of int, shape (n, k)
        The points of each neighborhood, itself among them.

    Returns
    -------
    normals : ndarray, shape (n, 3)
        Those of `fit_planes`.
    variation : ndarray, shape (n,)
        As `normals_and_variation` gives it, but for rounding.
    """
    normals, variation = np.empty((len(hoods), 3)), np.zeros(len(hoods))
    for start in range(0, len(hoods), _BLOCK):
        block = slice(start, start + _BLOCK)
        centers, normals[block] = fit_planes(points, hoods[block])
        offsets = points[hoods[block]] - centers[:, None]
        along = np.square(np.einsum("qki,qi->qk", offsets, normals[block])).sum(axis=1)
        total = np.square(offsets).sum(axis=(1, 2))
        np.divide(along, total, out=variation[block], where=total > 0)
    return normals, variation


def on_rim(points: Points, neighbors: IndexArray, normals: Points, counted: Mask | None = None) -> Mask:
    """Whether the directions to the neighbors, in the tangent plane, leave a gap of more than 90 degrees.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    neighbors : ndarray of int, shape (n, k)
    normals : ndarray, shape (n, 3)
    counted : ndarray of bool, shape (n, k), optional
        The neighbors that count; by default all.
    """
    counted = np.ones(neighbors.shape, bool) if counted is None else counted
    alone = np.logical_not(np.any(counted, axis=1))
    if alone.all():
        return alone
    offsets = points[neighbors] - points[:, None]
    axes = tangents(normals.T)
    aside, ahead = (np.einsum("nki,in->nk", offsets, axis) for axis in axes)
    angles = np.sort(np.where(counted, np.arctan2(ahead, aside), np.inf), axis=1)
    # what does not count stands at the end, and repeats the first angle one turn later
    closing = np.where(alone[:, None], 0.0, angles[:, :1]) + 2 * np.pi
    gaps = np.diff(np.minimum(angles, closing), axis=1, append=closing)
    return alone | (gaps.max(axis=1) > _WIDEST_GAP)


def thinned(points: Points, rows: IndexArray, limit: int) -> IndexArray:
    """At most ``limit`` of the given rows, far apart: the first ones of their farthest-point order."""
    if len(rows) <= limit:
        return rows
    if limit == 0:
        return rows[:0]
    return rows[farthest_points(points[rows], limit, 0)]
