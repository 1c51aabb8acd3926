"""The plane through one neighborhood, compiled, for methods that fit one plane at a time."""

from __future__ import annotations

import numpy as np
from numba import njit

_MOST_SWEEPS = 12


@njit("f8(f8[::1], f8[::1])", cache=True)
def dot(left, right):
    """Scalar product of two vectors of three."""
    return left[0] * right[0] + left[1] * right[1] + left[2] * right[2]


@njit("void(f8[:,::1], f8[:,::1])", cache=True)
def diagonalize(a, vectors):
    """Turn a symmetric 3 x 3 matrix into its eigenvalues, on its diagonal, by Jacobi's rotations.

    Parameters
    ----------
    a : ndarray, shape (3, 3)
        Changed in place.
    vectors : ndarray, shape (3, 3)
        Filled with the eigenvectors, one a column, in the order of the diagonal.
    """
    vectors[:] = np.eye(3)
    for _ in range(_MOST_SWEEPS):
        if abs(a[0, 1]) + abs(a[0, 2]) + abs(a[1, 2]) <= 1e-16 * (abs(a[0, 0]) + abs(a[1, 1]) + abs(a[2, 2])):
            return
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if a[p, q] == 0.0:
                continue
            theta = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
            t = (1.0 if theta >= 0 else -1.0) / (abs(theta) + np.sqrt(theta * theta + 1.0))
            c = 1.0 / np.sqrt(t * t + 1.0)
            s = t * c
            for k in range(3):
                a[k, p], a[k, q] = c * a[k, p] - s * a[k, q], s * a[k, p] + c * a[k, q]
            for k in range(3):
                a[p, k], a[q, k] = c * a[p, k] - s * a[q, k], s * a[p, k] + c * a[q, k]
            for k in range(3):
                u, v = vectors[k, p], vectors[k, q]
                vectors[k, p], vectors[k, q] = c * u - s * v, s * u + c * v


@njit("void(f8[:,::1], f8[::1], f8[::1], f8[:,::1])", cache=True)
def fit_plane(offsets, weights, center, axes):
    """Weighted mean of points and the principal axes around it.

    Parameters
    ----------
    offsets : ndarray, shape (k, 3)
        The points, relative to one nearby.
    weights : ndarray, shape (k,)
        Not negative, at least one positive.
    center : ndarray, shape (3,)
        Filled with the weighted mean.
    axes : ndarray, shape (3, 3)
        Filled with one unit axis a row: the direction of least variance first, the other two after it.
    """
    total = weights.sum()
    center[:] = 0.0
    for i in range(len(offsets)):
        for r in range(3):
            center[r] += weights[i] * offsets[i, r] / total
    covariance, vectors = np.zeros((3, 3)), np.empty((3, 3))
    for i in range(len(offsets)):
        for r in range(3):
            for c in range(r, 3):
                covariance[r, c] += weights[i] * (offsets[i, r] - center[r]) * (offsets[i, c] - center[c])
    for r in range(1, 3):
        for c in range(r):
            covariance[r, c] = covariance[c, r]
    diagonalize(covariance, vectors)
    least = 0
    for r in range(1, 3):
        if covariance[r, r] < covariance[least, least]:
            least = r
    for r in range(3):
        axes[r] = vectors[:, (least + r) % 3]
