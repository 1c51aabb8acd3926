"""Exchange of kept points against eq. 27, guarded against holes.

Every original belongs to its nearest kept point. In each round the few per cent of kept points that carry
the least error are dropped, and as many originals are taken where the error is largest, one in a cell.
Neighbours are never dropped together; nothing is dropped that would leave an original farther from the
reduced cloud than the hole limit, and originals that are farther already come first. Few rounds are enough,
and few is right: further rounds go on to win eq. 27 by losing the surface.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare.uniform.densities import DensityBand, bears
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
    if diagonal == 0:
        return kept
    tree = Neighbors((points - bounding_box_center(points)) / diagonal)
    rows = np.empty(len(points), dtype=np.intp)
    rows[tree.order] = np.arange(len(points))
    refined = swap_points(
        tree,
        rows[kept],
        n_rounds=n_rounds,
        exchange_share=exchange_share,
        hole_limit=hole_limit,
        band=band and band.sorted(tree.order),
    )
    return np.sort(tree.order[refined]).astype(np.intp)


def swap_points(
    tree: Neighbors,
    kept: Indices,
    *,
    n_rounds: int = 12,
    exchange_share: float = 0.06,
    hole_limit: float = 1.7,
    band: DensityBand | None = None,
) -> Indices:
    """`refine` for rows of ``tree.sorted_points``; so are the rows that it returns, and those of the band."""
    kept = np.sort(kept)
    if len(kept) < 4 or len(kept) == len(tree.points):
        return kept
    state = Neighborhoods(tree, kept)
    limit = hole_limit * _typical_radius(state)
    band = band or DensityBand(np.zeros(len(tree.points), dtype=np.intp), np.ones(len(tree.points)))
    best, best_rank = kept, state.rank(limit)
    for n_swaps in _schedule(len(kept), n_rounds, exchange_share):
        dropped, added = _choose(state, limit, band, n_swaps)
        if not len(added):
            break
        state.swap(dropped, added)
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
    np.maximum.at(radii, state.owners, state.gaps[:, 0])
    radii = radii[radii > 0]
    return float(np.sqrt(np.mean(radii**2))) if len(radii) else 0.0


def _choose(state: Neighborhoods, limit: float, band: DensityBand, n_swaps: int) -> tuple[Indices, Indices]:
    """The rows to drop and the rows to take, equally many, at most ``n_swaps``."""
    owners = state.owners
    mass = np.bincount(owners, weights=state.errors, minlength=len(state.kept))
    band.start(state.kept)
    dropped, blocked = _drops(state, limit, band, n_swaps, owners, mass)
    added = _additions(state, limit, band, len(dropped), owners, mass, blocked)
    return state.kept[dropped[: len(added)]], added


def _drops(
    state: Neighborhoods, limit: float, band: DensityBand, n_wanted: int, owners: Indices, mass: Vector
) -> tuple[Indices, Mask]:
    """Positions of kept points with little error that can go, and a mask of these and their neighbours."""
    reach = np.zeros(len(mass))
    np.maximum.at(reach, owners, state.gaps[:, 1])
    spare = np.flatnonzero(reach <= limit)
    ranking = np.lexsort((mass[spare], ~band.wants(state.kept[spare], -1)))
    order = spare[ranking[: _LOOK_AHEAD * n_wanted]]
    blocked = np.zeros(len(mass), dtype=np.bool_)
    rings = state.rings(order, _RING)
    return _take_out(order, state.kept, rings, blocked, band.arrays, n_wanted), blocked


@njit(cache=True, nogil=True)
def _take_out(order, kept, rings, blocked, band, n_wanted):
    """The first positions of ``order`` that are no neighbours of one another and that the density spares."""
    dropped = np.empty(n_wanted, np.int64)
    count = 0
    for i in range(len(order)):
        position = order[i]
        if count == n_wanted:
            break
        if blocked[position] or not bears(band, kept[position], -1, False):
            continue
        dropped[count] = position
        count += 1
        for neighbor in rings[i]:
            blocked[neighbor] = True
    return dropped[:count]


def _additions(
    state: Neighborhoods,
    limit: float,
    band: DensityBand,
    n_wanted: int,
    owners: Indices,
    mass: Vector,
    blocked: Mask,
) -> Indices:
    """Rows to take: holes first, then the worst original of each of the cells with the most error."""
    worst = _worst_of_each_cell(owners, state.gaps, state.errors, limit, state.errors.max(), len(mass))
    depth = np.where(state.gaps[worst, 0] > limit, state.gaps[worst, 0], 0.0)
    order = worst[np.lexsort((-mass[owners[worst]], ~band.wants(worst, 1), -depth))[: _LOOK_AHEAD * n_wanted]]
    return _take_in(order, owners[order], state.gaps[order, 0] > limit, blocked, band.arrays, n_wanted)


@njit(cache=True, nogil=True)
def _worst_of_each_cell(owners, gaps, errors, limit, above, n_cells):
    """The most urgent original of every cell that is not at the place of its kept point."""
    worst, most = np.full(n_cells, -1), np.full(n_cells, -1.0)
    for i in range(len(owners)):
        if gaps[i, 0] > 0:
            urgency = above + gaps[i, 0] if gaps[i, 0] > limit else errors[i]
            if urgency > most[owners[i]]:
                worst[owners[i]], most[owners[i]] = i, urgency
    return worst[worst >= 0]


@njit(cache=True, nogil=True)
def _take_in(order, cells, holes, blocked, band, n_wanted):
    """The first rows of ``order`` that close a hole, or that neither cell nor density forbids."""
    added = np.empty(n_wanted, np.int64)
    count = 0
    for i in range(len(order)):
        if count == n_wanted:
            break
        if (holes[i] or not blocked[cells[i]]) and bears(band, order[i], 1, holes[i]):
            added[count] = order[i]
            count += 1
    return added[:count]
