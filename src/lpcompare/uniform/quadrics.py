"""Tangent-plane quadrics: how badly a point at some place represents the originals around it.

Each original belongs to its two nearest sites and adds the squared distance to its tangent plane (Garland and
Heckbert, SIGGRAPH 1997, from points instead of triangles) and a small share of its squared distance, which
decides where the surface is flat. A rim adds the squared distance to a plane across the surface, so that a
cell at the rim is represented on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface
from lpcompare.threads import for_blocks
from lpcompare.types import Indices, Points, Vector
from lpcompare.uniform.rims import Rims

_SHARED = 2
_STIFFNESS = 0.1
_LARGEST_STEP = 0.25
_HALVINGS = 3


@dataclass(frozen=True, eq=False)
class Quadrics:
    """One quadric per site, in coordinates relative to the site.

    Attributes
    ----------
    sites : ndarray, shape (m, 3)
    owners : ndarray of int, shape (n,)
        Nearest site of each original.
    matrices, vectors, constants : ndarray, shapes (m, 3, 3), (m, 3), (m,)
        Area-weighted squared distance to the tangent planes: x' A x - 2 b' x + c.
    masses : ndarray, shape (m,)
        Area that each site stands for.
    """

    sites: Points
    owners: Indices
    matrices: NDArray[np.float64]
    vectors: Points
    constants: Vector
    masses: Vector

    def costs(self, points: Points, spread: float) -> Vector:
        """Cost of putting each original in the place of its site.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
            The originals.
        spread : float
            Weight of the squared distance to the site beside the squared distances to the tangent planes.

        Returns
        -------
        ndarray, shape (n,)
            Not negative.
        """
        costs = np.empty(len(points))
        arrays = self.sites, self.matrices, self.vectors, self.constants, spread * self.masses
        for_blocks(len(points), lambda b: _costs(points[b], self.owners[b], *arrays, costs[b]))
        return costs

    def minima(self, stiffness: float) -> Points:
        """Where each quadric, held to its site by ``stiffness`` times its trace, is least: shape (m, 3)."""
        traces = np.trace(self.matrices, axis1=1, axis2=2)
        held = self.matrices + (np.where(traces > 0, stiffness * traces, 1.0))[:, None, None] * np.eye(3)
        return self.sites + np.linalg.solve(held, self.vectors[:, :, None])[:, :, 0]


def tangent_quadrics(points: Points, surface: Surface, rims: Rims, sites: Points) -> Quadrics:
    """Gather the quadric of every site from the originals for which it is among the nearest sites.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    surface : Surface
        Of ``points``.
    rims : Rims
        Of ``points``.
    sites : ndarray, shape (m, 3)

    Returns
    -------
    Quadrics
    """
    n_sites = len(sites)
    nearest = Neighbors(sites).query(points, _SHARED)[1]
    matrices, vectors = np.zeros((n_sites, 3, 3)), np.zeros((n_sites, 3))
    constants, masses = np.zeros(n_sites), np.zeros(n_sites)
    sums = matrices, vectors, constants
    _gather(points, surface.normals, surface.areas, sites, nearest, *sums)
    rows = rims.rows
    _gather(points[rows], rims.directions, rims.areas, sites, nearest[rows, :1], *sums)
    for owners in nearest.T:
        masses += np.bincount(owners, surface.areas, n_sites)
    return Quadrics(sites, nearest[:, 0].copy(), matrices, vectors, constants, masses)


def place_points(tree: Neighbors, surface: Surface, rims: Rims, indices: Indices) -> Points:
    """Move each kept point to where it represents the originals around it best: `lp_placed`.

    Kept points of a convex surface lie on it, so that every plane through them cuts below it. The minimum of
    the tangent-plane quadric of a point lies a little outside, or on the edge where planes meet. The quadric
    needs no mesh; it is held to the kept point where the planes say nothing.

    Parameters
    ----------
    tree : Neighbors
        Of the original cloud; rows are those of ``tree.sorted_points``.
    surface : Surface
    rims : Rims
        Both of the originals.
    indices : ndarray of int, shape (m,)
        Rows that were kept.

    Returns
    -------
    ndarray, shape (m, 3)
        In the order of ``indices``. A point moves by at most a quarter of its distance to the next kept point.
        It ends no farther from the nearest original than the eighth neighbour of its own, and none of its
        originals ends farther from it than the farthest original was before; where a step breaks this, half
        of it is tried, then a quarter, then none.
    """
    points, sites = tree.sorted_points, tree.sorted_points[indices]
    quadrics = tangent_quadrics(points, surface, rims, sites)
    nearest, nearby = Neighbors(sites), np.sqrt(surface.areas[indices])
    spacings = nearest.query(sites, 2)[0][:, -1]
    steps = quadrics.minima(_STIFFNESS) - sites
    lengths = np.linalg.norm(steps, axis=1)
    steps *= np.minimum(1.0, _LARGEST_STEP * spacings / np.where(lengths > 0, lengths, 1.0))[:, None]
    limit = np.linalg.norm(points - sites[quadrics.owners], axis=1).max()
    lost = np.zeros(len(sites), dtype=bool)
    for _ in range(_HALVINGS):
        moved = sites + steps
        reach = np.zeros(len(sites))
        np.maximum.at(reach, quadrics.owners, np.linalg.norm(points - moved[quadrics.owners], axis=1))
        lost = (tree.query(moved, 1)[0][:, 0] > nearby) | (reach > limit)
        steps[lost] *= 0.5
    return sites + np.where(lost[:, None], 0.0, steps)


@njit(cache=True, nogil=True)
def _gather(points, normals, areas, sites, nearest, matrices, vectors, constants):
    """Add the squared distance to the plane through every point to the quadrics of its nearest sites."""
    for i in range(len(points)):
        area = areas[i]
        for site in nearest[i]:
            height = 0.0
            for a in range(3):
                height += (points[i, a] - sites[site, a]) * normals[i, a]
            constants[site] += area * height * height
            for a in range(3):
                vectors[site, a] += area * height * normals[i, a]
                for b in range(3):
                    matrices[site, a, b] += area * normals[i, a] * normals[i, b]


@njit(cache=True, nogil=True)
def _costs(points, owners, sites, matrices, vectors, constants, spreads, costs):
    """`Quadrics.costs` of one block."""
    for i in range(len(points)):
        site = owners[i]
        total, distance = constants[site], 0.0
        for a in range(3):
            offset = points[i, a] - sites[site, a]
            distance += offset * offset
            total -= 2 * offset * vectors[site, a]
            for b in range(3):
                total += offset * matrices[site, a, b] * (points[i, b] - sites[site, b])
        costs[i] = max(total, 0.0) + spreads[site] * distance


@njit(cache=True, nogil=True)
def cheapest_of_each(costs, cells, n_cells):
    """The row of least cost in each cell, the first among equals; -1 for a cell without rows."""
    chosen = np.full(n_cells, -1)
    for row in range(len(costs)):
        best = chosen[cells[row]]
        if best < 0 or costs[row] < costs[best]:
            chosen[cells[row]] = row
    return chosen
