"""Farthest point sampling over buckets of points: exact, and many points at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Indices, Mask, Points, Vector

_BUCKET_SIZE = 256
_LOOK_AHEAD = 0.7
"""A round considers points whose squared distance is at least this share of the largest one."""
_MOST_CANDIDATES = 2048
_PAIRS_AT_ONCE = 4096


def farthest_points(points: Points, target_count: int, first: int) -> Indices:
    """Rows in greedy order: each one farthest from those before it, the lowest row where distances tie.

    The points lie in the leaves of a balanced k-d tree (buckets). A bucket's farthest point is sure to be
    taken next in its surroundings when no bucket that it reaches holds one farther; all sure points are taken
    in one round. Some belong behind the target, which the final sort by distance removes.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    first : int
        The row to begin with.

    Returns
    -------
    ndarray of int, shape (target_count,)
    """
    tree = _Tree.over(points)
    taken, distances = [np.array([first])], [np.array([np.inf])]
    bucket, _ = (found[:1] for found in np.nonzero(tree.rows == first))
    tree.take(np.array([first]), bucket, np.zeros(len(tree.rows), int), np.arange(len(tree.rows)))
    while tree.largest >= 0 and np.count_nonzero(np.concatenate(distances) > tree.largest) < target_count:
        buckets = tree.candidates()
        rows, squared = tree.farthest[buckets], tree.distance[buckets]
        which, reached = tree.reach(rows, tree.distance)
        sure = tree.is_sure(buckets, which, reached)
        kept = sure[which]
        taken.append(rows[sure])
        distances.append(squared[sure])
        renumbered = np.cumsum(sure) - 1
        tree.take(rows[sure], buckets[sure], renumbered[which[kept]], reached[kept])
    order = np.lexsort((np.concatenate(taken), -np.concatenate(distances)))
    return np.concatenate(taken)[order[:target_count]]


@dataclass(eq=False)
class _Tree:
    """A balanced k-d tree whose leaves are equally large buckets, and the points' distances to those taken.

    Attributes
    ----------
    points : ndarray, shape (n + 1, 3)
        The cloud, and a filler that makes the buckets equally large.
    rows : ndarray of int, shape (b, s)
        The points of each bucket, ascending.
    columns : ndarray, shape (3, b, s)
        Their coordinates.
    low, high : list of ndarray, shapes (1, 3), (2, 3), ... (b, 3)
        The boxes of the nodes, level by level.
    nearest : ndarray, shape (b, s)
        Squared distance to the nearest taken point; -1 when taken, or filler.
    distance, farthest : ndarray, shape (b,)
        The largest of ``nearest`` in each bucket, and its row.
    """

    points: Points
    rows: NDArray[np.intp]
    columns: NDArray[np.float64]
    low: list[Points]
    high: list[Points]
    nearest: NDArray[np.float64]
    distance: Vector
    farthest: Indices

    @classmethod
    def over(cls, points: Points) -> _Tree:
        """Split the cloud at the median of its longest side until the buckets are small."""
        n = len(points)
        n_levels = max(0, int(np.ceil(np.log2(n / _BUCKET_SIZE))))
        n_buckets = 2**n_levels
        filled = np.vstack([points, points[:1]])
        rows = np.full((1, -(-n // n_buckets) * n_buckets), n)
        rows[0, :n] = np.arange(n)
        for _ in range(n_levels):
            rows = _halved(filled, rows)
        rows = np.sort(rows, axis=1)
        columns = np.ascontiguousarray(np.moveaxis(filled[rows], 2, 0))
        low, high = [columns.min(axis=2).T], [columns.max(axis=2).T]
        for _ in range(n_levels):
            low.insert(0, low[0].reshape(-1, 2, 3).min(axis=1))
            high.insert(0, high[0].reshape(-1, 2, 3).max(axis=1))
        nearest = np.where(rows == n, -1.0, np.inf)
        return cls(filled, rows, columns, low, high, nearest, nearest.max(axis=1), rows[:, 0].copy())

    @property
    def largest(self) -> float:
        """Largest squared distance of a point not yet taken; -1 when none is left."""
        return float(self.distance.max())

    def candidates(self) -> Indices:
        """The buckets whose farthest point may be taken in this round."""
        found = np.flatnonzero(self.distance >= _LOOK_AHEAD * self.largest)
        if len(found) > _MOST_CANDIDATES:
            found = found[np.argpartition(-self.distance[found], _MOST_CANDIDATES)[:_MOST_CANDIDATES]]
        return found

    def reach(self, rows: Indices, limits: Vector) -> tuple[Indices, Indices]:
        """Pairs (position in ``rows``, bucket) where the row is nearer to the bucket's box than its limit."""
        of_levels = [limits]
        while len(of_levels[0]) > 1:
            of_levels.insert(0, of_levels[0].reshape(-1, 2).max(axis=1))
        which, nodes = np.arange(len(rows)), np.zeros(len(rows), int)
        for level, limit in enumerate(of_levels):
            if level:
                which, nodes = np.repeat(which, 2), np.repeat(2 * nodes, 2)
                nodes[1::2] += 1
            near = self._box_distance(rows[which], nodes, level) < limit[nodes]
            which, nodes = which[near], nodes[near]
        return which, nodes

    def is_sure(self, buckets: Indices, which: Indices, reached: Indices) -> Mask:
        """Whether no point that a candidate may shorten, or be shortened by, comes before it."""
        row, squared = self.farthest[buckets][which], self.distance[buckets][which]
        before = (self.distance[reached] > squared) | (
            (self.distance[reached] == squared) & (self.farthest[reached] < row)
        )
        sure = np.ones(len(buckets), bool)
        sure[which[before]] = False
        return sure

    def take(self, rows: Indices, buckets: Indices, which: Indices, reached: Indices) -> None:
        """Take rows of given buckets, and shorten the distances in the buckets that each one reaches."""
        slots = (self.rows[buckets] == rows[:, None]).argmax(axis=1)
        self.nearest[buckets, slots] = -1.0
        order = np.argsort(reached, kind="stable")
        for start in range(0, len(order), _PAIRS_AT_ONCE):
            block = order[start : start + _PAIRS_AT_ONCE]
            self._shorten(rows[which[block]], reached[block])
        changed = np.unique(np.concatenate([reached, buckets]))
        nearest = self.nearest[changed]
        slots = nearest.argmax(axis=1)
        self.distance[changed] = nearest[np.arange(len(changed)), slots]
        self.farthest[changed] = self.rows[changed, slots]

    def _shorten(self, rows: Indices, buckets: Indices) -> None:
        """Distances of the buckets' points (ascending buckets, each with one row) to that row."""
        squared = np.zeros((len(buckets), self.rows.shape[1]))
        for column, coordinates in zip(self.columns, self.points[rows].T, strict=True):
            squared += (column[buckets] - coordinates[:, None]) ** 2
        starts = np.flatnonzero(np.diff(buckets, prepend=-1))
        reached = buckets[starts]
        self.nearest[reached] = np.minimum(
            self.nearest[reached], np.minimum.reduceat(squared, starts, axis=0)
        )

    def _box_distance(self, rows: Indices, nodes: Indices, level: int) -> Vector:
        """Squared distance of points to the boxes of nodes; never above that to a point inside."""
        queries = self.points[rows]
        gaps = np.maximum(self.low[level][nodes] - queries, queries - self.high[level][nodes])
        gaps = np.maximum(gaps, 0.0)
        return gaps[:, 0] ** 2 + gaps[:, 1] ** 2 + gaps[:, 2] ** 2


def _halved(points: Points, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Each node's rows (nodes, k) parted at the median of its longest side: (2 * nodes, k / 2)."""
    coordinates = points[rows]
    axis = np.ptp(coordinates, axis=1).argmax(axis=1)
    keys = np.take_along_axis(coordinates, axis[:, None, None], axis=2)[..., 0]
    half = rows.shape[1] // 2
    order = np.argpartition(keys, half, axis=1)
    return np.take_along_axis(rows, order, axis=1).reshape(-1, half)
