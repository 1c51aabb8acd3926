"""The nearest kept points of every original and its error, up to date while points are swapped.

Each original has a list of up to 16 kept points, nearest first, and the radius inside which the list is
complete. A swap squeezes the points that leave out of the lists, and inserts those that arrive inside the
radius. Only a list that becomes too short is looked up again. A trial does the same with a copy of one list at a
time, and keeps only the errors.

The error of an original mixes two distances: eq. 27's, to planes through its nearest kept points, and that to the
triangles around the nearest of them. Planes smooth; triangles feel a rim that is lost and a ridge that is cut.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numba import njit

from lpcompare.geometry.kernels import gather, mean_plane_distance, nearest_of
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.stars import Stars
from lpcompare.threads import for_blocks
from lpcompare.types import Indices, Points, Vector

SIZES = (6, 8, 12)
"""Neighbourhood sizes of eq. 27 that the error averages over: none is won at the cost of another."""

_CAPACITY = 16
_STARS = 3
_TRIANGLE_SCALE = 2.0
"""Distances to triangles are about half of those to planes."""
_LEAVES = 128


class Neighborhoods:
    """Nearest kept points of every original.

    Parameters
    ----------
    tree : Neighbors
        Of the originals, whose order all arrays follow: row ``i`` is ``tree.sorted_points[i]``.
    normals : ndarray, shape (n, 3)
        Of the originals.
    kept : ndarray of int, shape (m,)
        At least three rows.
    triangle_share : float
        Weight of the distance to triangles in the error, from 0 to 1.

    Attributes
    ----------
    kept : ndarray of int, shape (m,)
        Ascending.
    lists : ndarray of int32, shape (n, 16)
        Rows of the nearest kept points, nearest first; those after the first ``counts`` (n,) mean nothing.
    gaps : ndarray, shape (n, 2)
        Distances to the nearest kept point and to the next.
    errors : ndarray, shape (n,)
        Eq. 27 distance of each original, averaged over ``SIZES``, mixed with twice its distance to triangles.
    """

    def __init__(self, tree: Neighbors, normals: Points, kept: Indices, triangle_share: float) -> None:
        n_points, needed = len(tree.sorted_points), min(max(SIZES), len(kept))
        self._tree = tree
        self._sizes = np.array([size for size in SIZES if size < needed] + [needed])
        self._slots = np.zeros(n_points, dtype=np.int32)
        self.kept = np.sort(kept)
        self.lists = np.empty((n_points, _CAPACITY), dtype=np.int32)
        self.counts = np.zeros(n_points, dtype=np.int8)
        self._radii, self._normals, self._share = np.zeros(n_points), normals, triangle_share
        self.gaps, self._planes, self._triangles = (
            np.empty((n_points, 2)),
            np.empty(n_points),
            np.zeros(n_points),
        )
        self._stars = Stars(self._tree.sorted_points)
        self.swap(np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp))

    @property
    def owners(self) -> Indices:
        """For each original, the position in ``kept`` of its nearest kept point, shape (n,)."""
        return self._slots[self.lists[:, 0]].astype(np.intp)

    @property
    def points(self) -> Points:
        """The originals, shape (n, 3)."""
        return self._tree.sorted_points

    def rings(self, rows: Indices, size: int) -> Indices:
        """Positions in ``kept`` of the kept points nearest to each of the originals ``rows``."""
        return self._slots[self.lists[rows, : min(size, len(self.kept))]].astype(np.intp)

    def rank(self, limit: float) -> tuple[int, float]:
        """Originals beyond ``limit``, then the mean error: what a swap makes smaller."""
        return int(np.count_nonzero(self.gaps[:, 0] > limit)), float(self.errors.mean())

    def swap(self, dropped: Indices, added: Indices) -> None:
        """Replace kept points, and bring up to date the originals whose neighbours change."""
        change = self._renew(dropped, added, self._planes, stored=True)
        if self._share > 0:
            self._measure_triangles(change, self._triangles)
        self.kept, self._slots = change.kept, change.slots
        self.errors = self._mixed(self._planes, self._triangles)

    def try_swap(self, dropped: Indices, added: Indices) -> Vector:
        """The errors of the originals, shape (n,), if the points were swapped; nothing changes."""
        planes, triangles = self._planes.copy(), self._triangles
        change = self._renew(dropped, added, planes, stored=False)
        if self._share > 0:
            triangles, stars = triangles.copy(), self._stars.take(change.stale)
            self._measure_triangles(change, triangles)
            self._stars.put(change.stale, stars)
        return self._mixed(planes, triangles)

    def _mixed(self, planes: Vector, triangles: Vector) -> Vector:
        return (1 - self._share) * planes + self._share * _TRIANGLE_SCALE * triangles

    def _renew(self, dropped: Indices, added: Indices, planes: Vector, *, stored: bool) -> _Change:
        """Bring ``planes`` up to date after a swap; the lists and gaps as well where it is ``stored``."""
        points, leaves = self._tree.sorted_points, self._tree.leaves
        leaving = np.zeros(len(points), dtype=np.bool_)
        leaving[dropped] = True
        kept = np.sort(np.concatenate([self.kept[~leaving[self.kept]], added]))
        change = _Change(kept, added, len(points), int(self._sizes[-1]))
        arriving, all_kept = Neighbors(points[added]), Neighbors(points[kept])
        state = self.lists, self.counts, self._radii, self.gaps
        results = planes, change.firsts, change.sites, change.slots, change.nearest
        arrivals = (*arriving.arrays, added[arriving.order])
        everyone = (*all_kept.arrays, kept[all_kept.order])

        def renew(block: slice) -> None:
            some = leaves[block.start : block.stop + 1]
            _renew(some, points, state, results, leaving, arrivals, everyone, self._sizes, stored)

        for_blocks(len(leaves) - 1, renew, size=_LEAVES)
        return change

    def _measure_triangles(self, change: _Change, triangles: Vector) -> None:
        """Distance of the originals to the stars of their three nearest kept points, where one is another.

        A star depends on the list of its own point alone. The stars of points that were added may be of a time
        before they were dropped.
        """
        points, stale = self._tree.sorted_points, change.stale
        changed = self._stars.find(stale, self._normals, change.nearest[change.slots[stale]])

        def measure(block: slice) -> None:
            moved = change.firsts[block] < _STARS
            self._stars.renew(points[block], change.sites[block], moved, changed, triangles[block])

        for_blocks(len(points), measure)


class _Change:
    """What a swap of kept points leads to, once `_renew` has filled in ``firsts``, ``sites`` and ``nearest``.

    Attributes
    ----------
    kept, added : ndarray of int
        The kept points afterwards, ascending, and those among them that arrive.
    slots : ndarray of int32, shape (n,)
        The position in ``kept`` of each kept point; -1 elsewhere.
    firsts : ndarray of int8, shape (n,)
        First place of the list of each original that changes; the width of the lists if none does.
    sites : ndarray of int32, shape (n, 3)
        The nearest kept points of each original.
    nearest : ndarray of int32, shape (m, k)
        The kept points nearest to each kept point.
    """

    def __init__(self, kept: Indices, added: Indices, n_points: int, n_nearest: int) -> None:
        self.kept, self.added = kept, added
        self.slots = np.full(n_points, -1, dtype=np.int32)
        self.slots[kept] = np.arange(len(kept))
        self.firsts = np.empty(n_points, dtype=np.int8)
        self.sites = np.empty((n_points, _STARS), dtype=np.int32)
        self.nearest = np.empty((len(kept), n_nearest), dtype=np.int32)

    @cached_property
    def stale(self) -> Indices:
        """The kept points whose neighbours change, and those that arrive."""
        touched = self.firsts < self.nearest.shape[1]
        touched[self.added] = True
        return self.kept[touched[self.kept]]


@njit(cache=True, nogil=True)
def _renew(leaves, points, state, results, leaving, arrivals, everyone, sizes, stored):
    """Bring the originals between the places ``leaves`` up to date."""
    lists, counts, radii, gaps = state
    errors, firsts, sites, slots, nearest = results
    places, starts, boxes, rows = arrivals
    found = np.empty(len(places), np.int32)
    line, count, radius = np.empty_like(lists[:1]), np.empty_like(counts[:1]), np.empty_like(radii[:1])
    needed = sizes[-1]
    for leaf in range(len(leaves) - 1):
        begin, end = leaves[leaf], leaves[leaf + 1]
        n_found = 0
        if len(places) and begin < end:
            low, high, reach = np.full(3, np.inf), np.full(3, -np.inf), 0.0
            for i in range(begin, end):
                for a in range(3):
                    low[a], high[a] = min(low[a], points[i, a]), max(high[a], points[i, a])
                reach = max(reach, radii[i])
            n_found = gather(low, high, reach, places, starts, boxes, found)
        for i in range(begin, end):
            line[0], count[0], radius[0] = lists[i], counts[i], radii[i]
            first = _squeeze(line[0], count, leaving)
            for place in found[:n_found]:
                first = min(first, _insert(i, rows[place], points, line[0], count, radius))
            if count[0] < needed:
                _look_up(i, points, line[0], count, radius, everyone)
                first = 0
            firsts[i], sites[i] = first, line[0, : sites.shape[1]]
            if slots[i] >= 0:
                nearest[slots[i]] = line[0, :needed]
            if first < needed:
                x, y, z = points[i]
                errors[i] = mean_plane_distance(x, y, z, points, line[0], sizes)
            if stored and first < len(line[0]):
                lists[i], counts[i], radii[i] = line[0], count[0], radius[0]
                for j in range(2):
                    gaps[i, j] = np.sqrt(_squared_distance(points, i, line[0, j]))


@njit(cache=True, nogil=True)
def _squeeze(line, count, leaving):
    """Take the points that leave out of a list; the first place at which one did, or the list's width."""
    n_left, first = 0, len(line)
    for j in range(count[0]):
        if leaving[line[j]]:
            first = min(first, j)
        else:
            line[n_left] = line[j]
            n_left += 1
    count[0] = n_left
    return first


@njit(cache=True, nogil=True)
def _insert(i, row, points, line, count, radius):
    """Put a point that arrives in its place of a list; that place, or the list's width."""
    distance, width = _squared_distance(points, i, row), len(line)
    if distance >= radius[0]:
        return width
    j = count[0]
    if j == width:
        j -= 1
    else:
        count[0] += 1
    while j > 0 and _squared_distance(points, i, line[j - 1]) > distance:
        line[j] = line[j - 1]
        j -= 1
    line[j] = row
    if count[0] == width:
        radius[0] = _squared_distance(points, i, line[width - 1])
    return j


@njit(cache=True, nogil=True)
def _look_up(i, points, line, count, radius, everyone):
    """Make a list anew from the tree of all kept points."""
    places, starts, boxes, rows = everyone
    size = min(len(line), len(places))
    distances, nearest = np.full(size, np.inf), np.empty(size, np.int32)
    nearest_of(points[i, 0], points[i, 1], points[i, 2], places, starts, boxes, distances, nearest)
    for j in range(size):
        line[j] = rows[nearest[j]]
    count[0] = size
    radius[0] = distances[size - 1] if size < len(places) else np.inf


@njit(cache=True, nogil=True)
def _squared_distance(points, i, j):
    x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
    return x * x + y * y + z * z
