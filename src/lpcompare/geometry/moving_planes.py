"""The moving least squares plane of a cloud at a place."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.kernels import least_direction
from lpcompare.threads import for_blocks
from lpcompare.types import Points, Vector

_ROUNDS = 5


def moving_planes(
    queries: Points, points: Points, neighbors: NDArray[np.intp], *, n_rounds: int = _ROUNDS
) -> tuple[Points, Points, Vector]:
    """Foot of each query on the Gaussian-weighted plane of its neighbors: linear moving least squares.

    The weight of a neighbor p is exp(-|p - x|^2 / h^2), where x is the foot and h a third of the distance
    from the query to the farthest of its neighbors (Pauly, Gross and Kobbelt 2002, section 2.2). The plane
    holds the weighted mean, normal to the direction of least weighted variance. Plane and foot are found in
    turn, a fixed number of rounds, from x = the query.

    Parameters
    ----------
    queries : ndarray, shape (q, 3)
    points : ndarray, shape (n, 3)
    neighbors : ndarray of int, shape (q, k)
        Nearest points of each query, as rows of ``points``, nearest first.
    n_rounds : int, optional

    Returns
    -------
    feet : ndarray, shape (q, 3)
    normals : ndarray, shape (q, 3)
        Unit length; the sign is arbitrary.
    widths : ndarray, shape (q,)
        h, in the unit of the points; 0 where query and neighbors coincide.
    """
    feet, normals, widths = np.empty_like(queries), np.empty_like(queries), np.empty(len(queries))
    points, neighbors = np.ascontiguousarray(points), np.ascontiguousarray(neighbors)

    def work(block: slice) -> None:
        _block(queries[block], points, neighbors[block], n_rounds, feet[block], normals[block], widths[block])

    for_blocks(len(queries), work)
    return feet, normals, widths


@njit(cache=True, nogil=True)
def _block(queries, points, neighbors, n_rounds, feet, normals, widths):
    size = neighbors.shape[1]
    offsets, exponents = np.empty((size, 3)), np.empty(size)
    for q in range(len(queries)):
        for j in range(size):
            for i in range(3):
                offsets[j, i] = points[neighbors[q, j], i] - queries[q, i]
        x, y, z = offsets[size - 1]
        widths[q] = np.sqrt(x * x + y * y + z * z) / 3
        scale = widths[q] if widths[q] > 0 else 1.0
        foot, normal = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for _ in range(n_rounds):
            foot, normal = _foot(offsets, foot, scale, exponents)
        for i in range(3):
            feet[q, i], normals[q, i] = queries[q, i] + foot[i], normal[i]


@njit(cache=True, nogil=True)
def _foot(offsets, foot, scale, exponents):
    """One round: the foot of the query at zero on the plane of its neighbors, weighted around ``foot``."""
    fx, fy, fz = foot
    nearest = np.inf
    for j in range(len(offsets)):
        x, y, z = (offsets[j, 0] - fx) / scale, (offsets[j, 1] - fy) / scale, (offsets[j, 2] - fz) / scale
        exponents[j] = x * x + y * y + z * z
        nearest = min(nearest, exponents[j])
    # the nearest neighbor weighs one, so that the weights of a far query do not vanish together
    total, mx, my, mz = 0.0, 0.0, 0.0, 0.0
    for j in range(len(offsets)):
        weight = np.exp(nearest - exponents[j])
        exponents[j], total = weight, total + weight
        mx, my, mz = mx + weight * offsets[j, 0], my + weight * offsets[j, 1], mz + weight * offsets[j, 2]
    mx, my, mz = mx / total, my / total, mz / total
    xx = yy = zz = xy = xz = yz = 0.0
    for j in range(len(offsets)):
        weight, x, y, z = exponents[j], offsets[j, 0] - mx, offsets[j, 1] - my, offsets[j, 2] - mz
        xx, yy, zz = xx + weight * x * x, yy + weight * y * y, zz + weight * z * z
        xy, xz, yz = xy + weight * x * y, xz + weight * x * z, yz + weight * y * z
    normal = least_direction(xx, yy, zz, xy, xz, yz)
    height = mx * normal[0] + my * normal[1] + mz * normal[2]
    return (height * normal[0], height * normal[1], height * normal[2]), normal
