"""The nearest kept points of every original and its eq. 27 error, up to date while points are exchanged."""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.fits import mean_plane_distances
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Indices, Mask, Points

SIZES = (6, 8, 12)
"""Neighbourhood sizes of eq. 27 that the error averages over: none is won at the cost of another."""


class Neighborhoods:
    """Nearest kept points of every original.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Centred, in any unit.
    kept : ndarray of int, shape (m,)
        At least three rows of ``points``.

    Attributes
    ----------
    kept : ndarray of int, shape (m,)
        Ascending.
    distances, nearest : ndarray, shape (n, k)
        Distance and row of the nearest kept points, nearest first.
    errors : ndarray, shape (n,)
        Eq. 27 distance of each original, averaged over ``SIZES``.
    """

    def __init__(self, points: Points, kept: Indices) -> None:
        n_neighbors = min(max(SIZES), len(kept))
        self._points = points
        self._sizes = (*(size for size in SIZES if size < n_neighbors), n_neighbors)
        self.kept = np.sort(kept)
        self.distances = np.empty((len(points), n_neighbors))
        self.nearest = np.empty((len(points), n_neighbors), dtype=np.intp)
        self.errors = np.empty(len(points))
        self._look_up(np.arange(len(points)))

    @property
    def owners(self) -> Indices:
        """For each original, the position in ``kept`` of its nearest kept point, shape (n,)."""
        return np.searchsorted(self.kept, self.nearest[:, 0])

    def rings(self, positions: Indices, size: int) -> Indices:
        """Positions of the kept points nearest to those at ``positions``, each itself among them."""
        sites = self._points[self.kept]
        return Neighbors(sites).query(sites[positions], size)[1]

    def rank(self, limit: float) -> tuple[int, float]:
        """Originals beyond ``limit``, then the mean error: what an exchange makes smaller."""
        return int(np.count_nonzero(self.distances[:, 0] > limit)), float(self.errors.mean())

    def exchange(self, dropped: Indices, added: Indices) -> None:
        """Replace kept points and look up again only the originals whose neighbours change."""
        leaving = np.zeros(len(self._points), dtype=bool)
        leaving[dropped] = True
        changed: Mask = np.any(leaving[self.nearest], axis=1)
        others = np.flatnonzero(~changed)
        arrival = Neighbors(self._points[added]).query(self._points[others], 1)[0][:, 0]
        changed[others[arrival < self.distances[others, -1]]] = True
        self.kept = np.union1d(self.kept[~leaving[self.kept]], added)
        self._look_up(np.flatnonzero(changed))

    def _look_up(self, rows: Indices) -> None:
        queries = self._points[rows]
        n_neighbors = self.distances.shape[1]
        self.distances[rows], positions = Neighbors(self._points[self.kept]).query(queries, n_neighbors)
        self.nearest[rows] = self.kept[positions]
        self.errors[rows] = mean_plane_distances(queries, self._points, self.nearest[rows], self._sizes)
