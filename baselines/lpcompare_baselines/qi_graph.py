"""Quadratic program on a graph: feature points stay, and every neighbourhood keeps its share.

Qi, Hu and Guo, Feature preserving and uniformity-controllable point cloud simplification on graph, 2019.

1. The points are joined to their 15 nearest (K = 15), W_ij = exp(-d_ij^2 / s^2); L = I - D^-1 W.
2. A point's feature is f_i = |(L X)_i|^2, the energy of the high-pass filter.
3. With the 0/1 matrix A of each point's K nearest, a = m / n and y = a K, solve ::

       minimize    1/2 sum_i f_i (1 - x_i)^2  +  l/2 |A x - y 1|^2
       subject to  sum_i x_i = m,  0 <= x_i <= 1

   which keeps features and asks that every neighbourhood keep its share; l weighs the two.
4. The m largest x_i are kept.

Decisions: one sparse program for the whole cloud, where the authors' code solves dense blocks of some
thousand points; accelerated projected gradients (FISTA with restarts) until the step is small; f is divided
by its mean, because it grows with the square of the unit and l would depend on that; l = 3, the best of .03,
.3, 3, 30 and 300 over two shapes and two scans at 90 % (the authors' .001 is for their unit); equal x_i are
kept by feature, then by row.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from lpcompare.geometry.graphs import high_pass_energy, nearest_others
from lpcompare.geometry.shares import nearest_shares
from lpcompare.types import Points, Simplification, Traits, Vector

TRAITS = Traits(
    wraps="numpy, scipy.sparse",
    source="Qi, Hu and Guo, Feature preserving and uniformity-controllable point cloud simplification on "
    "graph, IEEE ICME 2019",
    licence="GPL-3.0-or-later",
    family="graph",
)

_STEPS = 300
_SMALL = 1e-5


def qi_graph(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 15,
    uniformity: float = 3.0,
) -> Simplification:
    """Keep the ``target_count`` points of the largest x.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    n_neighbors : int, optional
        K, the points of a neighbourhood.
    uniformity : float, optional
        l, the weight of the neighbourhoods' shares against the features, whose mean is 1.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    n = len(points)
    _, near = nearest_others(points, n_neighbors)
    k = near.shape[1]
    features = high_pass_energy(points, n_neighbors)
    members = csr_array((np.ones(n * k), near.ravel(), np.arange(n + 1) * k), shape=(n, n))
    shares = solve_shares(features, members, uniformity, target_count)
    kept = np.lexsort((np.arange(n), -features, -shares))[:target_count]
    indices = np.sort(kept)
    return Simplification(points[indices], indices)


def solve_shares(features: Vector, members: csr_array, uniformity: float, target_count: int) -> Vector:
    """The x of step 3, shape (n,).

    Parameters
    ----------
    features : ndarray, shape (n,)
        f of step 2.
    members : csr_array, shape (n, n)
        A of step 3.
    uniformity : float
        l of step 3.
    target_count : int
        m of step 3.
    """
    n, back = len(features), members.T.tocsr()
    rate = target_count / n
    wanted = rate * members.sum(axis=1)
    # the norm of A^T A is at most the largest row sum times the largest column sum
    curvature = features.max() + uniformity * members.sum(axis=1).max() * members.sum(axis=0).max() or 1.0
    shares = ahead = np.full(n, rate)
    momentum = 1.0
    for _ in range(_STEPS):
        slope = features * (ahead - 1.0) + uniformity * (back @ (members @ ahead - wanted))
        before, shares = shares, nearest_shares(ahead - slope / curvature, target_count)
        step = shares - before
        if np.abs(step).max() < _SMALL * rate:
            break
        # O'Donoghue and Candes 2015: where the momentum points uphill, it is dropped
        momentum = 1.0 if slope @ step > 0 else momentum
        following = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        ahead, momentum = shares + (momentum - 1) / following * step, following
    return shares
