"""Least-squares planes through neighbourhoods, by principal component analysis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.threads import for_blocks
from lpcompare.types import Indices, Points, Vector


def fit_planes(points: Points, indices: Indices) -> tuple[Points, Points]:
    """Plane through the centroid of each neighbourhood, normal to its direction of least variance.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    indices : ndarray of int, shape (q, k)
        The points of each neighbourhood, as rows of ``points``.

    Returns
    -------
    centroids : ndarray, shape (q, 3)
    normals : ndarray, shape (q, 3)
        Unit length; their sign is arbitrary. Where the plane is not unique (fewer than three distinct
        points, or a line) it is one of the planes that hold the points.
    """
    from lpcompare.geometry.kernels import plane_block

    centroids, normals = np.empty((2, len(indices), 3))
    for_blocks(
        len(indices), lambda rows: plane_block(points, _places(indices[rows]), centroids[rows], normals[rows])
    )
    return centroids, normals


def plane_distances(
    queries: Points, points: Points, indices: Indices, sizes: tuple[int, ...] | None = None
) -> Vector:
    """Distance of each query to the plane through its neighbours.

    Parameters
    ----------
    queries : ndarray, shape (q, 3)
    points : ndarray, shape (m, 3)
        The cloud that carries the planes.
    indices : ndarray of int, shape (q, k)
        The neighbours of each query, nearest first, as rows of ``points``.
    sizes : tuple of int, optional
        Neighbourhood sizes to average over, ascending, from 3 to k; by default k alone.

    Returns
    -------
    ndarray, shape (q,)
        Unsigned, in model units. With one neighbour, the distance to that point; with two, to their line.
    """
    from lpcompare.geometry.kernels import plane_distance_block

    if indices.shape[1] < 3:
        return _flat_distances(queries, points[indices])
    distances, wanted = np.empty(len(queries)), np.array(sizes or indices.shape[1:])
    for_blocks(
        len(queries),
        lambda rows: plane_distance_block(
            queries[rows], points, _places(indices[rows]), wanted, distances[rows]
        ),
    )
    return distances


def _places(indices: Indices) -> NDArray[np.int32]:
    """The one type that the kernels are compiled for."""
    return np.ascontiguousarray(indices, dtype=np.int32)


def _flat_distances(queries: Points, neighborhoods: Points) -> Vector:
    """Distance to the one neighbour, or to the line through two."""
    first = neighborhoods[:, 0]
    offset = queries - first
    axis = neighborhoods[:, -1] - first
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = np.divide(axis, length, out=np.zeros_like(axis), where=length > 0)
    along = np.einsum("qi,qi->q", offset, axis)[:, None] * axis
    return np.linalg.norm(offset - along, axis=1)
