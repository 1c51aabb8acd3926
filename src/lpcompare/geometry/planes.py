"""Least-squares planes through neighbourhoods, by principal component analysis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Points, Vector

_BLOCK = 65536


def fit_planes(neighborhoods: NDArray[np.float64]) -> tuple[Points, Points]:
    """Plane through the centroid of each neighbourhood, normal to its direction of least variance.

    Parameters
    ----------
    neighborhoods : ndarray, shape (q, k, 3)
        Points in model units.

    Returns
    -------
    centroids : ndarray, shape (q, 3)
    normals : ndarray, shape (q, 3)
        Unit length; their sign is arbitrary. Where the plane is not unique (fewer than three distinct
        points, or a line) it is one of the planes that hold the points.
    """
    centroids = neighborhoods.mean(axis=1)
    centred = neighborhoods - centroids[:, None, :]
    covariances = np.einsum("qki,qkj->qij", centred, centred, optimize=True)
    return centroids, np.linalg.eigh(covariances)[1][:, :, 0]


def plane_distances(queries: Points, points: Points, indices: NDArray[np.intp]) -> Vector:
    """Distance of each query to the plane through its neighbours.

    Parameters
    ----------
    queries : ndarray, shape (q, 3)
    points : ndarray, shape (m, 3)
        The cloud that carries the planes.
    indices : ndarray of int, shape (q, k)
        The neighbours of each query, as rows of ``points``.

    Returns
    -------
    ndarray, shape (q,)
        Unsigned, in model units. With one neighbour, the distance to that point; with two, to their line.
    """
    if indices.shape[1] < 3:
        return _flat_distances(queries, points[indices])
    distances = np.empty(len(queries))
    for start in range(0, len(queries), _BLOCK):
        block = slice(start, start + _BLOCK)
        centroids, normals = fit_planes(points[indices[block]])
        distances[block] = np.abs(np.einsum("qi,qi->q", queries[block] - centroids, normals))
    return distances


def _flat_distances(queries: Points, neighborhoods: NDArray[np.float64]) -> Vector:
    """Distance to the one neighbour, or to the line through two."""
    first = neighborhoods[:, 0]
    offset = queries - first
    axis = neighborhoods[:, -1] - first
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = np.divide(axis, length, out=np.zeros_like(axis), where=length > 0)
    along = np.einsum("qi,qi->q", offset, axis)[:, None] * axis
    return np.linalg.norm(offset - along, axis=1)
