"""The nearest kept points of every original and its error, up to date while points are swapped.

Each original has a list of up to 16 kept points, nearest first, and the radius inside which the list is
complete. A swap squeezes the points that leave out of the lists, and inserts those that arrive inside the
radius. Only a list that becomes too short is looked up again.

The error of an original mixes two distances: eq. 27's, to planes through its nearest kept points, and that to the
triangles around the nearest of them. Planes smooth; triangles feel a rim that is lost and a ridge that is cut.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.kernels import gather, mean_plane_distance, nearest_of
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.stars import Stars
from lpcompare.threads import for_blocks
from lpcompare.types import Indices, Points

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
        self.errors, self._stars = self._planes, Stars(self._tree.sorted_points)
        self._update(np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp))

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
        self._update(dropped, added)

    def _update(self, dropped: Indices, added: Indices) -> None:
        points, leaves = self._tree.sorted_points, self._tree.leaves
        leaving = np.zeros(len(points), dtype=np.bool_)
        leaving[dropped] = True
        self.kept = np.sort(np.concatenate([self.kept[~leaving[self.kept]], added]))
        self._slots[self.kept] = np.arange(len(self.kept))
        arriving, all_kept = Neighbors(points[added]), Neighbors(points[self.kept])
        firsts = np.empty(len(points), dtype=np.int8)
        state = self.lists, self.counts, self._radii, self.gaps, self._planes, firsts
        arrivals = (*arriving.arrays, added[arriving.order])
        everyone = (*all_kept.arrays, self.kept[all_kept.order])

        def renew(block: slice) -> None:
            some = leaves[block.start : block.stop + 1]
            _renew(some, points, state, leaving, arrivals, everyone, self._sizes)

        for_blocks(len(leaves) - 1, renew, size=_LEAVES)
        if self._share > 0:
            self._measure_triangles(firsts, added)
        self.errors = (1 - self._share) * self._planes + self._share * _TRIANGLE_SCALE * self._triangles

    def _measure_triangles(self, firsts: NDArray[np.int8], added: Indices) -> None:
        """Distance of the originals to the stars of their three nearest kept points, where one is another.

        A star depends on the list of its own point alone; ``firsts`` are the first places of the lists that
        changed. The stars of points that were ``added`` may be of a time before they were dropped.
        """
        points, n_nearest = self._tree.sorted_points, int(self._sizes[-1])
        touched = firsts < n_nearest
        touched[added] = True
        stale = self.kept[touched[self.kept]]
        changed = self._stars.find(stale, self._normals, self.lists[stale, :n_nearest])

        def measure(block: slice) -> None:
            sites = self.lists[block, :_STARS]
            rows = np.flatnonzero((firsts[block] < _STARS) | changed[sites].any(axis=1))
            self._triangles[block.start + rows] = self._stars.distances(points[block][rows], sites[rows])

        for_blocks(len(points), measure)


@njit(cache=True, nogil=True)
def _renew(leaves, points, state, leaving, arrivals, everyone, sizes):
    """Bring the originals between the places ``leaves`` up to date."""
    lists, counts, radii, gaps, errors, firsts = state
    places, starts, boxes, rows = arrivals
    found = np.empty(len(places), np.int32)
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
            first = _squeeze(i, lists, counts, leaving)
            for place in found[:n_found]:
                first = min(first, _insert(i, rows[place], points, lists, counts, radii))
            if counts[i] < needed:
                _look_up(i, points, lists, counts, radii, everyone)
                first = 0
            firsts[i] = first
            if first < needed:
                for j in range(2):
                    gaps[i, j] = np.sqrt(_squared_distance(points, i, lists[i, j]))
                x, y, z = points[i]
                errors[i] = mean_plane_distance(x, y, z, points, lists[i], sizes)


@njit(cache=True, nogil=True)
def _squeeze(i, lists, counts, leaving):
    """Take the points that leave out of a list; the first place at which one did, or the list's width."""
    count, first = 0, lists.shape[1]
    for j in range(counts[i]):
        row = lists[i, j]
        if leaving[row]:
            first = min(first, j)
        else:
            lists[i, count] = row
            count += 1
    counts[i] = count
    return first


@njit(cache=True, nogil=True)
def _insert(i, row, points, lists, counts, radii):
    """Put a point that arrives in its place of a list; that place, or the list's width."""
    distance, width = _squared_distance(points, i, row), lists.shape[1]
    if distance >= radii[i]:
        return width
    j = counts[i]
    if j == width:
        j -= 1
    else:
        counts[i] += 1
    while j > 0 and _squared_distance(points, i, lists[i, j - 1]) > distance:
        lists[i, j] = lists[i, j - 1]
        j -= 1
    lists[i, j] = row
    if counts[i] == width:
        radii[i] = _squared_distance(points, i, lists[i, width - 1])
    return j


@njit(cache=True, nogil=True)
def _look_up(i, points, lists, counts, radii, everyone):
    """Make a list anew from the tree of all kept points."""
    places, starts, boxes, rows = everyone
    count = min(lists.shape[1], len(places))
    distances, nearest = np.full(count, np.inf), np.empty(count, np.int32)
    nearest_of(points[i, 0], points[i, 1], points[i, 2], places, starts, boxes, distances, nearest)
    for j in range(count):
        lists[i, j] = rows[nearest[j]]
    counts[i] = count
    radii[i] = distances[count - 1] if count < len(places) else np.inf


@njit(cache=True, nogil=True)
def _squared_distance(points, i, j):
    x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
    return x * x + y * y + z * z
