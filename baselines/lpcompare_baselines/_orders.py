"""Orders of a cloud in which copies of a position come last, and draws by weight."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lpcompare.types import Indices, Points, Simplification, Vector


def copies_last(points: Points, order: Callable[[Points], Indices]) -> Indices:
    """All rows: the first of each position in the order that a function gives, then the copies by row.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    order : callable
        Its argument is the distinct points, by row; it returns each of their places once.

    Returns
    -------
    ndarray of int, shape (n,)
    """
    first = np.sort(np.unique(points, axis=0, return_index=True)[1])
    copies = np.delete(np.arange(len(points)), first)
    return np.concatenate([first[order(points[first])], copies])


def first_of(points: Points, rows: Indices, target_count: int) -> Simplification:
    """The thinning that keeps the first rows of an order, with their ranks as ``info["order"]``."""
    ranks = np.argsort(rows[:target_count])
    indices = rows[ranks]
    return Simplification(points[indices], indices, info={"order": ranks})


def drawn_by_weight(weights: Vector, target_count: int, rng: np.random.Generator) -> Indices:
    """Rows drawn without replacement in proportion to weights of 0 or more, ascending.

    Efraimidis and Spirakis 2006: the smallest exponential waiting times are such a draw. Rows without a weight
    come after all others.
    """
    draws = rng.exponential(size=len(weights))
    waiting = np.divide(draws, weights, out=np.full(len(weights), np.inf), where=weights > 0)
    return np.sort(np.lexsort((draws, waiting))[:target_count])
