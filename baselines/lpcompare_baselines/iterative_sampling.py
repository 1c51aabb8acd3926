"""Iterative sampling: the point nearest to its neighbour goes, unless it has already stood in for others.

After `pointIterativeSampling` of MeshLib, described from its documentation and source; written anew.

1. A point's score is the squared distance to its nearest point plus what was charged to it, at first nothing.
2. The point of the least score is removed, and its score is charged to its nearest point.
3. Points whose nearest point was removed look for the next nearest. Back to 2, until the count is reached.

There is no radius and no other setting. The order of removal does not depend on the count, so the points for
one count are the first of the points for any larger one.

Decisions: where scores tie, as those of mutual neighbours do, the later row goes, as in MeshLib; copies of a
position go before all others, which their score of 0 demands. Sums are kept in double precision, MeshLib's in
single.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Indices, Points, Simplification, Traits, Vector
from lpcompare_baselines._heap import heap_of, pop, settle
from lpcompare_baselines._orders import copies_last, first_of

TRAITS = Traits(
    wraps="numpy, numba",
    source="MeshLib, pointIterativeSampling, https://meshlib.io",
    licence="GPL-3.0-or-later",
    family="spacing",
    progressive=True,
)

_LISTED = 24
"""Neighbours that are listed at a time; when one list has run out, all are made again over the living."""


def iterative_sampling(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep the ``target_count`` points that would be removed last.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.

    Returns
    -------
    Simplification
        A subset of the input; ``info["order"]`` has the rank of each kept point, shape (m,).
    """
    return first_of(points, copies_last(points, removal_order), target_count)


def removal_order(points: Points) -> Indices:
    """Places of distinct points, the last to be removed first, shape (n,)."""
    living, charged, removed = np.arange(len(points)), np.zeros(len(points)), [np.arange(0)]
    while len(living) > 1:
        distances, near = nearest_others(points[living], _LISTED)
        charges = charged[living]
        gone = _remove(np.square(distances), near, charges)
        charged[living] = charges
        removed.append(living[gone])
        living = np.delete(living, gone)
    return np.concatenate([*removed, living])[::-1]


@njit(cache=True)
def _remove(squared: NDArray[np.float64], near: NDArray[np.intp], charged: Vector) -> Indices:
    """Steps 2 and 3 until a list of neighbours has run out, or one point is left: the rows removed."""
    n, n_listed = near.shape
    keys = squared[:, 0] + charged
    heap, places = heap_of(keys, True)
    following, is_gone = np.zeros(n, np.intp), np.zeros(n, np.bool_)
    waiting, next_waiting = np.full(n, -1), np.full(n, -1)
    for row in range(n):
        next_waiting[row], waiting[near[row, 0]] = waiting[near[row, 0]], row
    gone = np.empty(n - 1, np.intp)
    for step in range(n - 1):
        row = pop(heap, n - step, places, keys, True)
        gone[step], is_gone[row] = row, True
        nearest, size = near[row, following[row]], n - step - 1
        charged[nearest] += keys[row]
        keys[nearest] += keys[row]
        settle(places[nearest], heap, size, places, keys, True)
        other = waiting[row]
        while other >= 0:
            later = next_waiting[other]
            if not is_gone[other]:
                while following[other] < n_listed and is_gone[near[other, following[other]]]:
                    following[other] += 1
                if following[other] == n_listed:
                    return gone[: step + 1]
                nearest = near[other, following[other]]
                keys[other] = squared[other, following[other]] + charged[other]
                settle(places[other], heap, size, places, keys, True)
                next_waiting[other], waiting[nearest] = waiting[nearest], other
            other = later
    return gone
