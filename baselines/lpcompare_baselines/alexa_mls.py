"""The point that adds least to the moving-least-squares surface removed, again and again: a reading of Alexa 2001.

M. Alexa, J. Behr, D. Cohen-Or, S. Fleishman, D. Levin and C. T. Silva, Point Set Surfaces, IEEE Visualization
2001, 21-28; the 2017 paper's [17]. The text could not be read again for this file. The contribution of a point is
its distance to its own projection onto the surface that the other points define; the point of least contribution
goes, the contributions near it are computed again, until the count is reached.

The projection of r: a plane H with normal n that fits the neighbors, weighted by ``exp(-d^2 / h^2)`` with d
measured from q, the foot of r on H; a polynomial g of degree 2 over H that fits their heights with the same
weights; the projection is ``q + g(0, 0) n``.

Decisions:

- H comes from three rounds of weighted principal component analysis around the current q, in place of the
  non-linear minimization.
- ``h`` is a third of the distance to the farthest of the k nearest points that are left, after Pauly, Gross
  and Kobbelt 2002. It grows as the cloud thins. With a fixed h the fits become singular.
- With fewer than six neighbors, or where the fit is singular, the plane alone counts.
- Near a removed point are those that had it among their k nearest.
- The points are not projected first; the result is a subset.
- In flat places the contribution is 0, and in print noise decides there. See ``even`` of
  ``_elimination.eliminate`` for the rule that keeps them even and not empty.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._elimination import SIGNATURE, eliminate
from lpcompare_baselines._plane_kernel import dot, fit_plane

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Alexa, Behr, Cohen-Or, Fleishman, Levin and Silva, Point set surfaces, IEEE Visualization 2001",
    family="surface",
    reading=True,
)

_PLANE_ROUNDS = 3
_BANDWIDTH = 1.0 / 3.0
"""h as a share of the distance to the farthest neighbor."""
_COEFFICIENTS = 6
_SINGULAR = 1e-10
"""Pivot, as a share of the diagonal entry before elimination, below which a fit counts as singular."""


def alexa_mls(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 20
) -> Simplification:
    """Remove the points that the surface of the others misses least.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Points that define the surface near a point.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    kept = eliminate(points, target_count, contribution, n_neighbors, even=True).kept
    return Simplification(points[kept], kept)


@njit("f8(f8[:,::1], f8[::1])", cache=True)
def _last_unknown(matrix, right):
    """Last unknown of a symmetric system by elimination; 0 where a pivot nearly vanishes.

    Of the matrix only the upper half is looked at.
    """
    n = len(right)
    whole = np.diag(matrix).copy()
    for p in range(n):
        if matrix[p, p] <= _SINGULAR * whole[p]:
            return 0.0
        for r in range(p + 1, n):
            share = matrix[p, r] / matrix[p, p]
            for c in range(r, n):
                matrix[r, c] -= share * matrix[p, c]
            right[r] -= share * right[p]
    return right[n - 1] / matrix[n - 1, n - 1]


@njit("f8(f8[:,::1], f8[::1], f8[:,::1])", cache=True)
def height_of_fit(offsets, weights, axes):
    """Value at the origin of a weighted quadratic over the plane with the given axes; 0 where it is singular."""
    if len(offsets) < _COEFFICIENTS:
        return 0.0
    matrix, right = np.zeros((_COEFFICIENTS, _COEFFICIENTS)), np.zeros(_COEFFICIENTS)
    terms = np.empty(_COEFFICIENTS)
    for i in range(len(offsets)):
        f, u, v = dot(axes[0], offsets[i]), dot(axes[1], offsets[i]), dot(axes[2], offsets[i])
        # the constant comes last, so that elimination alone gives it
        terms[0], terms[1], terms[2], terms[3], terms[4], terms[5] = u * u, u * v, v * v, u, v, 1.0
        for r in range(_COEFFICIENTS):
            right[r] += weights[i] * terms[r] * f
            for c in range(r, _COEFFICIENTS):
                matrix[r, c] += weights[i] * terms[r] * terms[c]
    return _last_unknown(matrix, right)


@njit(SIGNATURE, cache=True)
def contribution(row, hood, points, _data):
    """Distance of a point to its projection onto the surface of its neighbors, in model units."""
    k = len(hood)
    offsets, weights = np.empty((k, 3)), np.empty(k)
    for i in range(k):
        for c in range(3):
            offsets[i, c] = points[hood[i], c] - points[row, c]
    radius = np.sqrt(dot(offsets[k - 1], offsets[k - 1]))
    if radius == 0.0:
        return 0.0
    offsets /= radius
    foot, center, axes = np.zeros(3), np.empty(3), np.zeros((3, 3))
    for _ in range(_PLANE_ROUNDS):
        for i in range(k):
            x, y, z = offsets[i, 0] - foot[0], offsets[i, 1] - foot[1], offsets[i, 2] - foot[2]
            weights[i] = np.exp(-(x * x + y * y + z * z) / _BANDWIDTH**2)
        fit_plane(offsets, weights, center, axes)
        foot[:] = dot(center, axes[0]) * axes[0]
    return radius * abs(dot(foot, axes[0]) + height_of_fit(offsets - foot, weights, axes))
