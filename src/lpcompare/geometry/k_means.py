"""The start of expectation maximization: k-means with spread first centres.

It is ours because the import of scikit-learn takes longer than all else that a first call does.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.types import Indices, Points, Vector

_MOST_ROUNDS = 300
_TOLERANCE = 1e-4
"""Sum of the squared moves of the centres that ends the rounds, in units of the points' mean variance."""


def k_means(points: Points, n_clusters: int, seed: int) -> Points:
    """Centres of k-means: Lloyd's rounds from the first centres of k-means++.

    Each first centre is the best of a few drawn candidates (Arthur and Vassilvitskii, k-means++: the advantages
    of careful seeding, 2007). Draws and rounds are those of scikit-learn's ``KMeans``.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    n_clusters : int
        At most the number of distinct points.
    seed : int

    Returns
    -------
    ndarray, shape (n_clusters, 3)
        A centre that loses all its points stays where it is.
    """
    middle = points.mean(axis=0)
    moved = points - middle
    centers = _first_centers(moved, n_clusters, np.random.RandomState(seed))
    enough = _TOLERANCE * moved.var(axis=0).mean()
    labels, earlier = nearest_centers(moved, centers), np.empty(0)
    for _ in range(_MOST_ROUNDS):
        centers, before = _means(moved, labels, centers), centers
        if np.array_equal(labels, earlier) or ((centers - before) ** 2).sum() <= enough:
            break
        earlier, labels = labels, nearest_centers(moved, centers)
    return centers + middle


def nearest_centers(points: Points, centers: Points) -> Indices:
    """The nearest of ``centers`` (K, 3) to each of ``points`` (n, 3): shape (n,)."""
    labels = np.empty(len(points), dtype=np.intp)
    label_block(points, centers, np.einsum("ci,ci->c", centers, centers), labels)
    return labels


def _first_centers(points: Points, n_clusters: int, draws: np.random.RandomState) -> Points:
    """Points that are drawn by their squared distance to those before them."""
    squares, n_candidates = np.einsum("ni,ni->n", points, points), 2 + int(np.log(n_clusters))
    chosen = [int(draws.choice(len(points), p=np.full(len(points), 1 / len(points))))]
    nearest = _squared_distances(points, squares, np.array(chosen))[0]
    for _ in range(1, n_clusters):
        wanted = draws.uniform(size=n_candidates) * nearest.sum()
        candidates = np.minimum(np.searchsorted(np.cumsum(nearest), wanted), len(points) - 1)
        gaps = np.minimum(nearest, _squared_distances(points, squares, candidates))
        best = int(np.argmin(gaps.sum(axis=1)))
        nearest = gaps[best]
        chosen.append(int(candidates[best]))
    return points[chosen]


def _squared_distances(points: Points, squares: Vector, rows: Indices) -> Points:
    """From some of the points to all, shape (r, n)."""
    return np.maximum(squares[rows, None] - 2 * points[rows] @ points.T + squares, 0.0)


def _means(points: Points, labels: Indices, centers: Points) -> Points:
    counts = np.bincount(labels, minlength=len(centers))[:, None]
    sums = np.column_stack([np.bincount(labels, points[:, i], len(centers)) for i in range(3)])
    return np.where(counts > 0, sums / np.maximum(counts, 1), centers)


@njit(cache=True, nogil=True)
def label_block(points, centers, squares, labels):
    """Fill ``labels`` (n,); ``squares`` are the squared norms of the centres."""
    for i in range(len(points)):
        x, y, z, least = points[i, 0], points[i, 1], points[i, 2], np.inf
        for c in range(len(centers)):
            distance = squares[c] - 2 * (x * centers[c, 0] + y * centers[c, 1] + z * centers[c, 2])
            if distance < least:
                least, labels[i] = distance, c
