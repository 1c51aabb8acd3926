"""Eq. 27 distances for several neighbourhood sizes at once.

The planes through the nearest 6, 8 and 12 points share their sums, and the normal of a plane has a closed
form (the trigonometric solution of the 3 x 3 characteristic cubic; Smith, CACM 4(4), 1961). One pass costs
a fraction of three calls of `lpcompare.geometry.planes.plane_distances`, which judges; this one only steers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.planes import plane_distances
from lpcompare.types import Points, Vector

Array = NDArray[np.float64]

_BLOCK = 8192
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_UNDECIDED = 1e-10


def mean_plane_distances(
    queries: Points, points: Points, neighbors: NDArray[np.intp], sizes: tuple[int, ...]
) -> Vector:
    """Distance of each query to the planes through its nearest points, averaged over neighbourhood sizes.

    Parameters
    ----------
    queries : ndarray, shape (q, 3)
    points : ndarray, shape (n, 3)
        The cloud that ``neighbors`` points into.
    neighbors : ndarray of int, shape (q, k)
        Nearest points of each query, nearest first.
    sizes : tuple of int
        Ascending, from 3 to k.

    Returns
    -------
    ndarray, shape (q,)
        In the unit of ``points``.
    """
    means = np.empty(len(queries))
    for start in range(0, len(queries), _BLOCK):
        rows = slice(start, start + _BLOCK)
        means[rows] = _mean_distances(queries[rows], points, neighbors[rows], sizes)
    return means


def _mean_distances(
    queries: Points, points: Points, neighbors: NDArray[np.intp], sizes: tuple[int, ...]
) -> Vector:
    offsets = np.ascontiguousarray((points[neighbors] - queries[:, None]).transpose(2, 1, 0))
    first = np.zeros((3, len(queries)))
    second = np.zeros((6, len(queries)))
    total = np.zeros(len(queries))
    taken = 0
    for size in sizes:
        ring = offsets[:, taken:size]
        first += ring.sum(axis=1)
        for row, (i, j) in enumerate(_PAIRS):
            second[row] += np.einsum("kq,kq->q", ring[i], ring[j])
        taken = size
        distances, undecided = _plane_offsets(first / size, second / size)
        if undecided.any():
            nearest = neighbors[undecided, :size]
            distances[undecided] = plane_distances(queries[undecided], points, nearest)
        total += distances
    return total / len(sizes)


def _plane_offsets(centroid: Array, moments: Array) -> tuple[Vector, NDArray[np.bool_]]:
    """Distance of the origin to each PCA plane, and where the closed form cannot tell the normal."""
    covariance = moments - np.stack([centroid[i] * centroid[j] for i, j in _PAIRS])
    normals, undecided = _least_directions(covariance)
    return np.abs(np.einsum("iq,iq->q", centroid, normals)), undecided


def _least_directions(covariance: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Unit eigenvectors (3, q) of the least eigenvalue of symmetric matrices (xx, xy, xz, yy, yz, zz; q)."""
    mean = (covariance[0] + covariance[3] + covariance[5]) / 3
    scale = np.where(mean > 0, mean, 1.0)
    xx, xy, xz, yy, yz, zz = scaled = covariance / scale
    least = _least_eigenvalue(scaled)
    xx, yy, zz = xx - least, yy - least, zz - least
    # the rows of the singular matrix span the plane, so that their cross products are its normal
    products = np.stack(
        [
            (xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy),
            (xy * zz - xz * yz, xz * xz - xx * zz, xx * yz - xy * xz),
            (yy * zz - yz * yz, yz * xz - xy * zz, xy * yz - yy * xz),
        ]
    )
    lengths = np.einsum("piq,piq->pq", products, products)
    best = lengths.argmax(axis=0)
    columns = np.arange(best.size)
    length = np.sqrt(lengths[best, columns])
    undecided = length < _UNDECIDED
    return products[best, :, columns].T / np.where(undecided, 1.0, length), undecided


def _least_eigenvalue(covariance: Array) -> Vector:
    """Least eigenvalue of symmetric matrices (xx, xy, xz, yy, yz, zz; q) of trace three (or zero)."""
    xx, xy, xz, yy, yz, zz = covariance
    mean = (xx + yy + zz) / 3
    a, b, c = xx - mean, yy - mean, zz - mean
    spread = np.sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    cosine = np.divide(determinant, 2 * spread**3, out=np.zeros_like(spread), where=spread > 1e-30)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3
    return mean + 2 * spread * np.cos(angle + 2 * np.pi / 3)
