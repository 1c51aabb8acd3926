"""Exchange of kept points against eq. 27, guarded against holes.

Every original belongs to its nearest kept point. In each round the few per cent of kept points that carry the
least error are dropped, and as many originals are taken where the error is largest, one in a cell. Neighbours
are never dropped together; nothing is dropped that would leave an original farther from the reduced cloud than
the hole limit, and originals that are farther already come first. Few rounds are enough, and few is right:
further rounds go on to win eq. 27 by losing the surface.
"""

from __future__ import annotations

import numpy as np

from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.refinement.density import DensityBand
from lpcompare.refinement.neighborhoods import Neighborhoods
from lpcompare.types import Indices, Points, Vector

_LAST_SHARE = 0.2
_LOOK_AHEAD = 4
_RING = 5


def refine(
    points: Points,
    indices: Indices,
    *,
    n_rounds: int = 12,
    exchange_share: float = 0.04,
    hole_limit: float = 2.4,
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
        the cells of the subset. About 1.9 of these are the Hausdorff distance of a Poisson disk sampling.
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
    limit = hole_limit * _cell_radius(state)
    best, best_rank = kept, _rank(state, limit)
    for n_exchanges in _schedule(len(kept), n_rounds, exchange_share):
        dropped, added = _choose(points, state, limit, n_exchanges, band)
        if not len(added):
            break
        state.exchange(dropped, added)
        best, best_rank = min((best, best_rank), (state.kept, _rank(state, limit)), key=lambda pair: pair[1])
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


def _cell_radius(state: Neighborhoods) -> float:
    """Root mean square distance of the originals to their kept point, every cell counting alike."""
    owners, squares = state.owners, state.distances[:, 0] ** 2
    sizes = np.bincount(owners, minlength=len(state.kept))
    return float(np.sqrt(np.mean(np.bincount(owners, squares, len(state.kept)) / np.maximum(sizes, 1))))


def _rank(state: Neighborhoods, limit: float) -> tuple[int, float]:
    return int(np.count_nonzero(state.distances[:, 0] > limit)), float(state.errors.mean())


def _choose(
    points: Points, state: Neighborhoods, limit: float, n_exchanges: int, band: DensityBand | None
) -> tuple[Indices, Indices]:
    """The rows to drop and the rows to take, equally many."""
    owners = state.owners
    mass = np.bincount(owners, state.errors, len(state.kept))
    if band:
        band.start(state.kept)
    dropped, blocked = _drops(points, state, owners, mass, limit, n_exchanges, band)
    added = _additions(state, owners, mass, limit, len(dropped), blocked, band)
    return state.kept[dropped[: len(added)]], np.array(added, dtype=np.intp)


def _drops(
    points: Points,
    state: Neighborhoods,
    owners: Indices,
    mass: Vector,
    limit: float,
    n_exchanges: int,
    band: DensityBand | None,
) -> tuple[list[int], set[int]]:
    """Positions of the kept points with the least error that can go, and of these and their neighbours."""
    reach = np.zeros(len(mass))
    np.maximum.at(reach, owners, state.distances[:, 1])
    spare = np.flatnonzero(reach <= limit)
    order = spare[np.argsort(mass[spare], kind="stable")][: _LOOK_AHEAD * n_exchanges]
    kept_points = points[state.kept]
    rings = Neighbors(kept_points).query(kept_points[order], _RING)[1]
    dropped: list[int] = []
    blocked: set[int] = set()
    for position, row, ring in zip(order.tolist(), state.kept[order].tolist(), rings.tolist(), strict=True):
        if position in blocked or (band and not band.allows(row, -1)):
            continue
        if band:
            band.take(row, -1)
        dropped.append(position)
        blocked.update(ring)
        if len(dropped) == n_exchanges:
            break
    return dropped, blocked


def _additions(
    state: Neighborhoods,
    owners: Indices,
    mass: Vector,
    limit: float,
    n_wanted: int,
    blocked: set[int],
    band: DensityBand | None,
) -> list[int]:
    """Rows to take: holes first, then the worst original of each of the cells that carry the most error."""
    gaps = state.distances[:, 0]
    hole = gaps > limit
    urgency = np.where(hole, state.errors.max() + gaps, state.errors)
    candidates = np.flatnonzero(gaps > 0)
    candidates = candidates[np.lexsort((-urgency[candidates], owners[candidates]))]
    _, first = np.unique(owners[candidates], return_index=True)
    worst = candidates[first]
    order = np.lexsort((-mass[owners[worst]], -np.where(hole[worst], gaps[worst], 0.0)))
    added: list[int] = []
    for row in worst[order[: _LOOK_AHEAD * max(n_wanted, 1)]].tolist():
        if len(added) == n_wanted:
            break
        if not hole[row] and (int(owners[row]) in blocked or (band and not band.allows(row, 1))):
            continue
        if band:
            band.take(row, 1)
        added.append(row)
    return added
