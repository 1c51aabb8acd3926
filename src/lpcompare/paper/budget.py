"""How many points each cluster keeps: whole numbers that add up to the target."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices


def allocate_budget(total: int, sizes: Indices) -> Indices:
    """Share ``total`` among clusters in proportion to their sizes, by largest remainder.

    Parameters
    ----------
    total : int
        From 0 to the sum of ``sizes``.
    sizes : ndarray of int, shape (K,)
        Points that each cluster can give.

    Returns
    -------
    ndarray of int, shape (K,)
        Sums exactly to ``total``; no entry exceeds its size. Ties go to the lower cluster.
    """
    n_points = max(int(sizes.sum()), 1)
    shares, remainders = np.divmod(sizes.astype(np.int64) * int(total), n_points)
    left = int(total) - int(shares.sum())
    shares[np.argsort(-remainders, kind="stable")[:left]] += 1
    return shares.astype(np.intp)


def split_budget(budget: Indices, n_features: Indices, feature_share: float) -> tuple[Indices, Indices]:
    """Divide each cluster's budget between its feature points and its program.

    Parameters
    ----------
    budget : ndarray of int, shape (K,)
        Points that each cluster keeps.
    n_features : ndarray of int, shape (K,)
        Feature points of each cluster.
    feature_share : float
        Features come first until they fill this share of the budget.

    Returns
    -------
    features, chosen : ndarray of int, shape (K,)
        They sum to ``budget``.
    """
    features = np.minimum(n_features, np.floor(np.round(feature_share * budget, 9)).astype(np.intp))
    return features, budget - features
