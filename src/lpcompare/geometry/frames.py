"""Normals of many planes at once, and a frame around each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ISOLATED = 1e-6


def least_variance_directions(covariances: Array) -> Array:
    """Unit eigenvector of the smallest eigenvalue of many symmetric 3 x 3 matrices.

    The eigenvalue comes from the trigonometric solution of the characteristic cubic and the vector from a
    cross product of two rows; where the two smallest eigenvalues nearly agree, from LAPACK.

    Parameters
    ----------
    covariances : ndarray, shape (6, q)
        Entries xx, yy, zz, xy, xz, yz.

    Returns
    -------
    ndarray, shape (3, q)
        The sign is arbitrary.
    """
    largest = np.abs(covariances).max(axis=0)
    xx, yy, zz, xy, xz, yz = covariances / np.where(largest > 0, largest, 1.0)
    third = (xx + yy + zz) / 3
    a, b, c = xx - third, yy - third, zz - third
    spread = np.sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    half = determinant / (2 * np.where(spread > 0, spread, 1.0) ** 3)
    angle = np.arccos(np.clip(half, -1.0, 1.0)) / 3 + 2 * np.pi / 3
    smallest = 2 * spread * np.cos(angle)
    rows = np.stack([a - smallest, xy, xz, xy, b - smallest, yz, xz, yz, c - smallest]).reshape(3, 3, -1)
    crosses = np.stack([_cross(rows[i], rows[j]) for i, j in ((0, 1), (0, 2), (1, 2))])
    sizes = np.einsum("riq,riq->rq", crosses, crosses)
    best = np.argmax(sizes, axis=0)
    columns = np.arange(len(best))
    squared = sizes[best, columns]
    directions = crosses[best, :, columns].T / np.sqrt(np.where(squared > 0, squared, 1.0))
    unclear = np.flatnonzero(squared < _ISOLATED**2 * np.where(spread > 0, spread, 1.0) ** 4)
    if len(unclear):
        directions[:, unclear] = _by_lapack(covariances[:, unclear])
    return directions


def tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors (3, q) that make a right-handed frame with each unit normal (3, q).

    Duff and others, Building an orthonormal basis, revisited, JCGT 6(1), 2017.
    """
    x, y, z = normals
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x])
    return first, np.stack([b, sign + y * y * a, -y])


def _cross(left: Array, right: Array) -> Array:
    return np.stack(
        [
            left[1] * right[2] - left[2] * right[1],
            left[2] * right[0] - left[0] * right[2],
            left[0] * right[1] - left[1] * right[0],
        ]
    )


def _by_lapack(covariances: Array) -> Array:
    matrices = covariances[(0, 3, 4, 3, 1, 5, 4, 5, 2), :].T.reshape(-1, 3, 3)
    return np.linalg.eigh(matrices)[1][:, :, 0].T
