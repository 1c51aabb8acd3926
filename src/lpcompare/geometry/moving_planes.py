"""The moving least squares plane of a cloud at a place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.frames import least_variance_directions
from lpcompare.types import Points, Vector

_BLOCK = 16384
_ROUNDS = 5
_ENTRIES = 0, 4, 8, 1, 2, 5
"""Where xx, yy, zz, xy, xz, yz stand in a flattened matrix."""


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
    for start in range(0, len(queries), _BLOCK):
        block = slice(start, start + _BLOCK)
        offsets = points[neighbors[block]] - queries[block, None]
        widths[block] = np.linalg.norm(offsets[:, -1], axis=1) / 3
        foot, normals[block] = _feet(offsets, widths[block], n_rounds)
        feet[block] = queries[block] + foot
    return feet, normals, widths


def _feet(offsets: NDArray[np.float64], widths: Vector, n_rounds: int) -> tuple[Points, Points]:
    """Feet relative to the queries, and normals; ``offsets`` (q, k, 3) are those of the neighbors."""
    foot = np.zeros((len(offsets), 3))
    normals = foot
    scale = np.where(widths > 0, widths, 1.0)[:, None]
    for _ in range(n_rounds):
        exponents = np.square((offsets - foot[:, None]) / scale[:, None]).sum(axis=2)
        # the nearest neighbor weighs one, so that the weights of a far query do not vanish together
        weights = np.exp(exponents.min(axis=1, keepdims=True) - exponents)
        weights /= weights.sum(axis=1, keepdims=True)
        mean = np.matmul(weights[:, None], offsets)[:, 0]
        centred = (offsets - mean[:, None]).transpose(0, 2, 1)
        covariance = np.matmul(centred * weights[:, None], centred.transpose(0, 2, 1))
        normals = least_variance_directions(covariance.reshape(-1, 9).T[list(_ENTRIES)]).T
        foot = np.einsum("qi,qi->q", mean, normals)[:, None] * normals
    return foot, normals
