"""Removal of the least important point, one after the other, with importance kept up to date.

The methods of this kind differ in what a point is worth, which follows from its nearest points that are left.
The loop is theirs together: a heap of importance, and for each point a list of its nearest points. The lists
are longer than needed. They are made again when a share of the points is gone, or when one of them runs
short. So the neighborhoods are those of the points left, exactly, at every step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit, types
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare_baselines._heap import pop, settle
from lpcompare_baselines._hoods import IndexArray, nearest_others

SIGNATURE = types.float64(types.int64, types.int64[::1], types.float64[:, ::1], types.float64[:, ::1])
"""Of an importance, for ``numba.njit``: (row, rows of its neighborhood, points, data) -> importance."""

Importance = Callable[[int, Indices, Points, NDArray[np.float64]], float]

_SPARE, _SHORTEST_LIST = 3, 24
_RENEWED_AT = 0.7
"""Share of the points left at which the lists are made again."""
_GAP_NEIGHBORS = 6
_EVENNESS = 1e-3
_WIDEST_GAP = 1.5
"""Largest gap in a flat place, over that of an even result."""


class Elimination(NamedTuple):
    """What is left and what went.

    Attributes
    ----------
    kept : ndarray of int, shape (m,)
        Ascending.
    removed : ndarray of int, shape (n - m,)
        In the order of removal.
    values : ndarray, shape (n - m,)
        The importance of each one when it was removed.
    """

    kept: Indices
    removed: Indices
    values: Vector


def eliminate(
    points: Points,
    target_count: int,
    importance: Importance,
    n_neighbors: int,
    *,
    data: NDArray[np.float64] | None = None,
    fixed: Mask | None = None,
    even: bool = False,
) -> Elimination:
    """Remove the point of least importance until ``target_count`` are left; the lowest row where two are equal.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n, and not below the number of fixed points.
    importance : callable
        Compiled with `SIGNATURE`. The neighborhood comes nearest first.
    n_neighbors : int
        Points of a neighborhood, the point itself not counted; fewer where fewer are left.
    data : ndarray, shape (n, c), optional
        What else the importance needs to know of each point.
    fixed : ndarray of bool, shape (n,), optional
        Points that are never removed.
    even : bool, optional
        Thin flat places evenly and empty none. The gap at a point is the mean distance to its six nearest
        points. A thousandth of the gap is added to the importance, so that the most crowded of equal points
        goes first. A point whose gap exceeds one and a half times that of an even result (its gap in the
        input times the square root of n / target) comes after all others.
    """
    n = len(points)
    fixed = np.zeros(n, bool) if fixed is None else fixed
    data = np.zeros((n, 0)) if data is None else np.ascontiguousarray(data)
    limits = _gap_limits(points, target_count) if even else np.zeros(0)
    beyond_all = bounding_box_diagonal(points) or 1.0
    alive, removed, values = np.ones(n, bool), np.empty(n, np.int64), np.empty(n)
    n_removed = 0
    while n - n_removed > target_count:
        n_left = n - n_removed
        n_wanted = n_left - max(target_count, int(_RENEWED_AT * n_left), min(n_neighbors + 1, n_left - 1))
        near, starts, who = _lists(points, alive, n_neighbors)
        n_removed += _remove(
            importance, points, data, near, starts, who, alive, fixed, limits, beyond_all,
            min(n_neighbors, n_left - 1), n_wanted, removed[n_removed:], values[n_removed:],
        )  # fmt: skip
    return Elimination(np.flatnonzero(alive), removed[:n_removed], values[:n_removed])


def _gap_limits(points: Points, target_count: int) -> Vector:
    gaps = nearest_others(points, _GAP_NEIGHBORS)[0].sum(axis=1) / _GAP_NEIGHBORS
    return _WIDEST_GAP * np.sqrt(len(points) / target_count) * gaps


def _lists(points: Points, alive: Mask, n_neighbors: int) -> tuple[IndexArray, Indices, Indices]:
    """Nearest living points of each living one (n, l), and for each one who has it in his list, end to end."""
    rows = np.flatnonzero(alive)
    listed = rows[nearest_others(points[rows], max(_SPARE * n_neighbors, _SHORTEST_LIST))[1]]
    near = np.zeros((len(points), listed.shape[1]), np.int64)
    near[rows] = listed
    ends = listed.shape[1] * np.arange(len(rows) + 1)
    ones = np.ones(listed.size, np.int8)
    who = csr_array((ones, listed.ravel(), ends), (len(rows), len(points))).tocsc()
    return near, who.indptr.astype(np.int64), rows[who.indices]


_REMOVE = types.int64(
    types.FunctionType(SIGNATURE),
    types.float64[:, ::1],
    types.float64[:, ::1],
    types.int64[:, ::1],
    types.int64[::1],
    types.int64[::1],
    types.boolean[::1],
    types.boolean[::1],
    types.float64[::1],
    types.float64,
    types.int64,
    types.int64,
    types.int64[::1],
    types.float64[::1],
)


@njit("i8(i8, i8, i8[:,::1], b1[::1], i8[::1])", cache=True)
def _neighborhood(row, gone, near, alive, hood):
    """Fill ``hood`` with the nearest living points: 1 when it had ``gone`` before, 0 when not, -1 when short."""
    found, affected = 0, 0
    for other in near[row]:
        if other == gone:
            affected = 1
        elif alive[other]:
            hood[found] = other
            found += 1
            if found == len(hood):
                return affected
    return -1


@njit("f8(f8, i8, i8[::1], f8[:,::1], f8[::1], f8)", cache=True)
def _kept_even(value, row, hood, points, limits, beyond_all):
    gap = 0.0
    for other in hood[:_GAP_NEIGHBORS]:
        x, y, z = points[other] - points[row]
        gap += np.sqrt(x * x + y * y + z * z) / _GAP_NEIGHBORS
    return beyond_all + gap if gap > limits[row] else value + _EVENNESS * gap


@njit(_REMOVE, cache=True)
def _remove(
    importance, points, data, near, starts, who, alive, fixed, limits, beyond_all, n_neighbors, n_wanted,
    removed, values,
):  # fmt: skip
    """Remove up to ``n_wanted`` points; fewer when a list runs short. Returns how many."""
    heap = np.flatnonzero(alive & ~fixed)
    place, keys = np.full(len(points), -1), np.empty(len(points))
    for at, row in enumerate(heap):
        place[row] = at
        hood = near[row, :n_neighbors]
        keys[row] = importance(row, hood, points, data)
        if len(limits):
            keys[row] = _kept_even(keys[row], row, hood, points, limits, beyond_all)
    size = len(heap)
    for at in range(size):
        settle(at, heap, at + 1, place, keys)
    hood = np.empty(n_neighbors, np.int64)
    for done in range(n_wanted):
        row = pop(heap, size, place, keys)
        size -= 1
        removed[done], values[done] = row, keys[row]
        alive[row] = False
        if done + 1 == n_wanted:
            break
        for other in who[starts[row] : starts[row + 1]]:
            if place[other] < 0:
                continue
            state = _neighborhood(other, row, near, alive, hood)
            if state < 0:
                return done + 1
            if state:
                keys[other] = importance(other, hood, points, data)
                if len(limits):
                    keys[other] = _kept_even(keys[other], other, hood, points, limits, beyond_all)
                settle(place[other], heap, size, place, keys)
    return n_wanted
