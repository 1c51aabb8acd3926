"""Removal of the least important point, one after the other, with importance kept up to date.

The methods of this kind differ in what a point is worth, which follows from its nearest points that are left.
The loop is theirs together: a heap of importance, and for each point a list of its nearest points, longer than
needed. A list that runs short is asked for again, and all lists when a share of the points is gone. So the
neighborhoods are those of the points left, exactly, at every step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare_baselines._heap import pop, settle
from lpcompare_baselines._hoods import IndexArray

SIGNATURE = types.float64(types.int64, types.int64[::1], types.float64[:, ::1], types.float64[:, ::1])
"""Of an importance, for ``numba.njit``: (row, rows of its neighborhood, points, data) -> importance."""

Importance = Callable[[int, Indices, Points, NDArray[np.float64]], float]

_SPARE, _SHORTEST_LIST = 2, 16
"""Entries of a list, over those needed, and at least."""
_RENEWED_AT = 0.7
"""Share of the points left at which all lists are made again."""
_MOST_SHORT = 0.05
"""Lists asked for one by one, as a share of the points, from which all new ones cost less."""
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
    n, n_removed = len(points), 0
    data = np.zeros((n, 0)) if data is None else np.ascontiguousarray(data)
    limits = _gap_limits(points, target_count) if even else np.zeros(0)
    worth = importance, points, data, limits, bounding_box_diagonal(points) or 1.0
    alive, removed, values = np.ones(n, bool), np.empty(n, np.int64), np.empty(n)
    while n - n_removed > target_count:
        n_left = n - n_removed
        n_stop = n - max(target_count, int(_RENEWED_AT * n_left), min(n_neighbors + 1, n_left - 1))
        lists = _Lists(points, alive, min(n_neighbors, n_left - 1))
        stale = np.flatnonzero(alive if fixed is None else alive & ~fixed)
        heap, place, keys = np.zeros_like(stale), np.full(n, -1), np.empty(n)
        size = 0
        while n_removed < n_stop and lists.n_spare >= 0:
            n_removed, size, stale = _remove(
                *worth, lists.n_neighbors, *lists.arrays, alive, stale, heap, size, place, keys,
                removed, values, n_removed, n_stop,
            )  # fmt: skip
            lists.renew(stale)
    return Elimination(np.flatnonzero(alive), removed[:n_removed], values[:n_removed])


def _gap_limits(points: Points, target_count: int) -> Vector:
    gaps = nearest_others(points, _GAP_NEIGHBORS)[0].sum(axis=1) / _GAP_NEIGHBORS
    return _WIDEST_GAP * np.sqrt(len(points) / target_count) * gaps


class _Lists:
    """The nearest points of each point that is left, and for each point who has it in his list.

    Attributes
    ----------
    n_neighbors : int
    arrays : tuple of ndarray
        The lists, shape (n, l), nearest first, -1 after the last; and chains of those who have a point in their
        list: where the chain of each point begins, shape (n,), and who stands at each place of it and which
        place is next, shape (c,) each, -1 at the end.
    n_spare : int
        Lists that can still be asked for one by one.
    """

    def __init__(self, points: Points, alive: Mask, n_neighbors: int) -> None:
        self.points, self.alive, self.n_neighbors = points, alive, n_neighbors
        self.rows = np.flatnonzero(alive)
        listed = nearest_others(points[self.rows], max(_SPARE * n_neighbors, _SHORTEST_LIST))[1]
        near = np.full((len(points), listed.shape[1]), -1, np.int32)
        near[self.rows] = self.rows[listed]
        self.n_spare = int(_MOST_SHORT * len(self.rows)) + 1
        first = np.full(len(points), -1, np.int32)
        who, after = np.empty((2, (len(self.rows) + self.n_spare) * near.shape[1]), np.int32)
        self.arrays = near, first, who, after
        self._n_linked = _link(self.rows, *self.arrays, 0)
        self._tree: Neighbors | None = None

    def renew(self, rows: Indices) -> None:
        """Ask the tree for the lists of rows, unless there are too many of them."""
        near = self.arrays[0]
        self.n_spare -= len(rows)
        if self.n_spare < 0 or len(rows) == 0:
            return
        self._tree = self._tree or Neighbors(self.points[self.rows])
        n_asked = 2 * near.shape[1]
        found, usable = self._asked(rows, n_asked)
        while usable.sum(axis=1).min() < self.n_neighbors:
            n_asked *= 2
            found, usable = self._asked(rows, n_asked)
        found = np.where(usable, found, -1)
        near[rows] = np.take_along_axis(found, np.argsort(~usable, axis=1, kind="stable"), axis=1)[
            :, : near.shape[1]
        ]
        self._n_linked = _link(rows, *self.arrays, self._n_linked)

    def _asked(self, rows: Indices, n_asked: int) -> tuple[IndexArray, NDArray[np.bool_]]:
        """The nearest points of rows in the tree (q, n_asked), and whether each is left and another one."""
        assert self._tree is not None
        found = self.rows[self._tree.query(self.points[rows], n_asked)[1]]
        return found, self.alive[found] & (found != rows[:, None])


@njit("i8(i8[::1], i4[:,::1], i4[::1], i4[::1], i4[::1], i8)", cache=True)
def _link(rows, near, first, who, after, n_linked):
    """Enter rows in the chains of the points in their lists; returns how many places are used."""
    for row in rows:
        for other in near[row]:
            if other >= 0:
                who[n_linked], after[n_linked], first[other] = row, first[other], n_linked
                n_linked += 1
    return n_linked


@njit("i8(i8, i8, i4[:,::1], b1[::1], i8[::1])", cache=True)
def _neighborhood(row, gone, near, alive, hood):
    """Fill ``hood`` with the nearest points left: 1 when ``gone`` was among them, 0 when not, -1 when short."""
    found, affected = 0, 0
    for other in near[row]:
        if other == gone:
            affected = 1
        elif other >= 0 and alive[other]:
            hood[found] = other
            found += 1
            if found == len(hood):
                return affected
    return -1


@njit(types.float64(types.FunctionType(SIGNATURE), *SIGNATURE.args[2:], types.float64[::1], types.float64,
                    *SIGNATURE.args[:2]), cache=True)  # fmt: skip
def _worth(importance, points, data, limits, beyond_all, row, hood):
    """Importance of a point, evened out where there are limits; see ``even`` of `eliminate`."""
    value = importance(row, hood, points, data)
    if len(limits) == 0:
        return value
    gap = 0.0
    for other in hood[:_GAP_NEIGHBORS]:
        squared = 0.0
        for c in range(3):
            squared += (points[other, c] - points[row, c]) ** 2
        gap += np.sqrt(squared) / _GAP_NEIGHBORS
    return beyond_all + gap if gap > limits[row] else value + _EVENNESS * gap


_REMOVE = types.Tuple((types.int64, types.int64, types.int64[::1]))(
    types.FunctionType(SIGNATURE), *SIGNATURE.args[2:], types.float64[::1], types.float64,
    types.int64, types.int32[:, ::1], types.int32[::1], types.int32[::1], types.int32[::1],
    types.boolean[::1], types.int64[::1], types.int64[::1], types.int64, types.int64[::1], types.float64[::1],
    types.int64[::1], types.float64[::1], types.int64, types.int64,
)  # fmt: skip


@njit(_REMOVE, cache=True)
def _remove(
    importance, points, data, limits, beyond_all, n_neighbors, near, first, who, after, alive, stale, heap, size,
    place, keys, removed, values, n_removed, n_stop,
):  # fmt: skip
    """Value the stale rows, then remove points until ``n_stop`` are gone or lists run short.

    Returns how many are gone, the heap's size, and the rows whose lists ran short: the next stale ones.
    """
    hood = np.empty(n_neighbors, np.int64)
    for row in stale:
        _neighborhood(row, -1, near, alive, hood)
        keys[row] = _worth(importance, points, data, limits, beyond_all, row, hood)
        if place[row] < 0:
            heap[size], place[row] = row, size
            size += 1
        settle(place[row], heap, size, place, keys)
    short = np.empty(len(points), np.int64)
    n_short = 0
    while n_removed < n_stop and n_short == 0:
        gone = pop(heap, size, place, keys)
        size -= 1
        removed[n_removed], values[n_removed] = gone, keys[gone]
        alive[gone] = False
        n_removed += 1
        at = first[gone] if n_removed < n_stop else -1
        while at >= 0:
            row = who[at]
            at = after[at]
            if place[row] < 0:
                continue
            state = _neighborhood(row, gone, near, alive, hood)
            if state < 0:
                short[n_short] = row
                n_short += 1
            elif state:
                keys[row] = _worth(importance, points, data, limits, beyond_all, row, hood)
                settle(place[row], heap, size, place, keys)
    return n_removed, size, short[:n_short].copy()
