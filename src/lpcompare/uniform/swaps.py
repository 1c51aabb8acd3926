"""Exchange of kept points against eq. 27, guarded against holes.

Every original belongs to its nearest kept point. In each round the few per cent of kept points that carry
the least error are dropped, and as many originals are taken where the error is largest, one in a cell.
Neighbours are never dropped together; nothing is dropped that would leave an original farther from the
reduced cloud than the hole limit, and originals that are farther already come first. Few rounds are enough,
and few is right: further rounds go on to win eq. 27 by losing the surface.
"""

from __future__ import annotations

import numpy as np

from lpcompare.errors import InputError
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare.uniform.densities import DensityBand
from lpcompare.uniform.neighborhoods import Neighborhoods

_LAST_SHARE = 0.2
_LOOK_AHEAD = 4
_RING = 5


def refine(
    points: Points,
    indices: Indices,
    *,
    n_rounds: int = 12,
    exchange_share: float = 0.06,
    hole_limit: float = 1.7,
    band: DensityBand | None = None,
) -> Indices:
    """Exchange points of a subset so that the eq. 27 error falls and no hole opens.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The original cloud, finite, in model units.
    indices : ndarray of int, shape (m,)
        The rows kept, distinct.
    n_rounds : int
        Rounds of exchange; 0 changes nothing.
    exchange_share : float
        Share of the kept points that the first round may exchange; the last round exchanges a fifth of it.
    hole_limit : float
        Largest distance of an original to the reduced cloud, as a multiple of the root mean square radius of
        the cells of the subset. 1.05 to 1.3 of these are the Hausdorff distance of a Poisson disk sampling.
    band : DensityBand, optional
        Keeps the density of every cluster (eqs. 24-25).

    Returns
    -------
    ndarray of int, shape (m,)
        Ascending, exactly as many as given: of the selections met, the one with the fewest originals beyond
        the hole limit and, among these, the least error.

    Raises
    ------
    InputError
        A setting is out of its range, or ``indices`` are not distinct rows of ``points``.
    """
    kept = _checked(points, indices, n_rounds, exchange_share, hole_limit)
    diagonal = bounding_box_diagonal(points)
    if len(kept) < 4 or len(kept) == len(points) or diagonal == 0:
        return kept
    state = Neighborhoods((points - bounding_box_center(points)) / diagonal, kept)
    limit = hole_limit * _typical_radius(state)
    best, best_rank = kept, state.rank(limit)
    for n_exchanges in _schedule(len(kept), n_rounds, exchange_share):
        exchange = _Round(state, limit, band)
        dropped, added = exchange.choose(n_exchanges)
        if not len(added):
            break
        state.exchange(dropped, added)
        best, best_rank = min((best, best_rank), (state.kept, state.rank(limit)), key=lambda pair: pair[1])
    return best


def _checked(
    points: Points, indices: Indices, n_rounds: int, exchange_share: float, hole_limit: float
) -> Indices:
    kept = np.unique(indices)
    if not len(kept) or len(kept) != len(indices) or kept[0] < 0 or kept[-1] >= len(points):
        raise InputError(f"indices must be distinct rows from 0 to {len(points) - 1}, at least one of them.")
    if n_rounds < 0:
        raise InputError(f"n_rounds is {n_rounds}; it must be 0 or more.")
    if not 0 < exchange_share <= 0.5:
        raise InputError(f"exchange_share is {exchange_share}; it must be above 0 and at most 0.5.")
    if not hole_limit > 0:
        raise InputError(f"hole_limit is {hole_limit}; it must be above 0.")
    return kept.astype(np.intp)


def _schedule(n_kept: int, n_rounds: int, share: float) -> list[int]:
    """Exchanges allowed in each round, falling linearly."""
    shares = np.linspace(share, _LAST_SHARE * share, n_rounds)
    return np.maximum(shares * n_kept, 1).astype(int).tolist()


def _typical_radius(state: Neighborhoods) -> float:
    """Root mean square radius of the cells that hold more than their kept point."""
    radii = np.zeros(len(state.kept))
    np.maximum.at(radii, state.owners, state.distances[:, 0])
    radii = radii[radii > 0]
    return float(np.sqrt(np.mean(radii**2))) if len(radii) else 0.0


class _Round:
    """One round of exchanges: what is dropped, and what is taken instead."""

    def __init__(self, state: Neighborhoods, limit: float, band: DensityBand | None) -> None:
        self._state, self._limit, self._band = state, limit, band
        self._owners = state.owners
        self._mass = np.bincount(self._owners, weights=state.errors, minlength=len(state.kept))
        if band:
            band.start(state.kept)

    def choose(self, n_exchanges: int) -> tuple[Indices, Indices]:
        """The rows to drop and the rows to take, equally many, at most ``n_exchanges``."""
        dropped, blocked = self._drops(n_exchanges)
        added = self._additions(len(dropped), blocked)
        return self._state.kept[dropped[: len(added)]], np.array(added, dtype=np.intp)

    def _drops(self, n_wanted: int) -> tuple[list[int], set[int]]:
        """Positions of kept points with little error that can go, and of these and their neighbours."""
        reach = np.zeros(len(self._mass))
        np.maximum.at(reach, self._owners, self._state.distances[:, 1])
        spare = np.flatnonzero(reach <= self._limit)
        ranking = np.lexsort((self._mass[spare], ~self._wants(self._state.kept[spare], -1)))
        order = spare[ranking[: _LOOK_AHEAD * n_wanted]]
        rows, rings = self._state.kept[order].tolist(), self._state.rings(order, _RING).tolist()
        dropped: list[int] = []
        blocked: set[int] = set()
        for position, row, ring in zip(order.tolist(), rows, rings, strict=True):
            if len(dropped) == n_wanted:
                break
            if position in blocked or not self._bears(row, -1):
                continue
            dropped.append(position)
            blocked.update(ring)
        return dropped, blocked

    def _additions(self, n_wanted: int, blocked: set[int]) -> list[int]:
        """Rows to take: holes first, then the worst original of each of the cells with the most error."""
        gaps = self._state.distances[:, 0]
        hole = gaps > self._limit
        worst = self._worst_of_each_cell(np.where(hole, self._state.errors.max() + gaps, self._state.errors))
        depth = np.where(hole[worst], gaps[worst], 0.0)
        order = np.lexsort((-self._mass[self._owners[worst]], ~self._wants(worst, 1), -depth))
        added: list[int] = []
        for row in worst[order[: _LOOK_AHEAD * n_wanted]].tolist():
            if len(added) == n_wanted:
                break
            if hole[row]:
                self._count(row, 1)
            elif int(self._owners[row]) in blocked or not self._bears(row, 1):
                continue
            added.append(row)
        return added

    def _worst_of_each_cell(self, urgency: Vector) -> Indices:
        """The most urgent original of every cell that is not at the place of its kept point."""
        rows = np.flatnonzero(self._state.distances[:, 0] > 0)
        rows = rows[np.lexsort((-urgency[rows], self._owners[rows]))]
        return rows[np.flatnonzero(np.diff(self._owners[rows], prepend=-1))]

    def _wants(self, rows: Indices, change: int) -> Mask:
        """Rows whose exchange repairs a density; they come before the others."""
        return self._band.wants(rows, change) if self._band else np.zeros(len(rows), dtype=bool)

    def _bears(self, row: int, change: int) -> bool:
        """Whether the density bears a point more or less; if so, it is counted."""
        if self._band and not self._band.allows(row, change):
            return False
        self._count(row, change)
        return True

    def _count(self, row: int, change: int) -> None:
        if self._band:
            self._band.take(row, change)
