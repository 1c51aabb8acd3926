"""Swaps of kept points: those that a trial shows to pay, guarded against holes.

Every original belongs to its nearest kept point. In each round some kept points whose originals carry little
error are dropped, and originals are taken where the error is largest, none beside another. This is a trial: the
errors afterwards say what each drop cost and each addition gained. A boolean program chooses those that are done,
so that they save most and the clusters keep their densities. So a point that lies off its
surface, which an outlier or noise makes look urgent, does not stay: it spoils the planes of its neighbours.
Nothing is dropped that would leave an original farther from the reduced cloud than the hole limit, and
originals that are farther already come first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from lpcompare.checks import check_choice, check_integer
from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.geometry.surface import estimate_surface
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare.uniform.densities import DensityBand
from lpcompare.uniform.disks import disk_radius
from lpcompare.uniform.neighborhoods import Neighborhoods
from lpcompare.uniform.swap_program import choose_swaps

_FIRST_SHARE = 0.2
_LAST_SHARE = 0.04
_LOOK_AHEAD = 4
_RING = 5
_DENSITY_PRICE = 3.0
"""What one cell's worth of error a swap may cost that brings a density back by one point's share."""


@dataclass(frozen=True)
class Emphasis:
    """What swaps look at.

    Attributes
    ----------
    hole_limit : float
        Largest distance of an original to the reduced cloud, in units of the radius of a Poisson disk sampling
        of as many points, which is about its Hausdorff distance.
    triangle_share : float
        Share of the distance to triangles in the error; the rest is eq. 27.
    """

    hole_limit: float
    triangle_share: float


EMPHASES = {
    "balanced": Emphasis(hole_limit=1.28, triangle_share=0.2),
    "error": Emphasis(hole_limit=1.8, triangle_share=0.0),
    "coverage": Emphasis(hole_limit=1.1, triangle_share=0.2),
}


def refine(points: Points, indices: Indices, *, n_rounds: int = 8, emphasis: str = "balanced") -> Indices:
    """Improve any subset of a cloud by swaps, without regard to clusters.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The original cloud, finite, in model units.
    indices : ndarray of int, shape (m,)
        The rows kept, distinct.
    n_rounds : int
        Rounds of swaps; 0 changes nothing.
    emphasis : str
        One of `EMPHASES`.

    Returns
    -------
    ndarray of int, shape (m,)
        As `swap_points` gives it.

    Raises
    ------
    InputError
        A setting is out of its range, or ``indices`` are not distinct rows of ``points``.
    """
    chosen = EMPHASES[check_choice("emphasis", emphasis, EMPHASES)]
    n_rounds = check_integer("n_rounds", n_rounds, 0)
    kept = np.unique(indices).astype(np.intp)
    if not len(kept) or len(kept) != len(indices) or kept[0] < 0 or kept[-1] >= len(points):
        raise InputError(f"indices must be distinct rows from 0 to {len(points) - 1}, at least one of them.")
    tree = Neighbors(normalize(points)[0])
    places = tree.in_rows(np.arange(len(points)))
    normals = estimate_surface(tree).normals
    swapped = swap_points(tree, normals, places[kept], n_rounds=n_rounds, emphasis=chosen)
    return np.sort(tree.order[swapped].astype(np.intp))


def swap_points(
    tree: Neighbors,
    normals: Points,
    kept: Indices,
    *,
    n_rounds: int = 8,
    emphasis: Emphasis = EMPHASES["balanced"],
    band: DensityBand | None = None,
    limit: float | None = None,
    movable: Mask | None = None,
) -> Indices:
    """Swap points of a subset so that the error falls and no hole opens.

    Parameters
    ----------
    tree : Neighbors
        Of the originals; rows are those of ``tree.sorted_points``.
    normals : ndarray, shape (n, 3)
        Of the originals.
    kept : ndarray of int, shape (m,)
        The rows kept, distinct.
    n_rounds : int
        Rounds of swaps; 0 changes nothing.
    emphasis : Emphasis
    band : DensityBand, optional
        Keeps the density of every cluster (eqs. 24-25).
    limit : float, optional
        The hole limit, by default that of a Poisson disk sampling of as many points.
    movable : ndarray of bool, shape (n,), optional
        Rows that may be dropped or added; by default all. The others lie around a part of a larger cloud.

    Returns
    -------
    ndarray of int, shape (m,)
        Ascending, exactly as many as given: of the selections met, the one with the fewest originals beyond
        the hole limit and, among these, the least error.
    """
    kept = np.sort(kept)
    if len(kept) < 4 or len(kept) == len(tree.points) or n_rounds == 0:
        return kept
    state = Neighborhoods(tree, normals, kept, emphasis.triangle_share)
    if limit is None:
        limit = emphasis.hole_limit * disk_radius(tree.sorted_points, len(kept))
    n_movable = len(kept) if movable is None else int(np.count_nonzero(movable[kept]))
    band = band or DensityBand(np.zeros(len(tree.points), dtype=np.intp), np.ones(len(tree.points)))
    best, best_rank = kept, state.rank(limit)
    for share in np.linspace(_FIRST_SHARE, _LAST_SHARE, n_rounds):
        if not _swap_once(state, limit, band, max(int(share * n_movable), 1), movable):
            break
        best, best_rank = min((best, best_rank), (state.kept, state.rank(limit)), key=lambda pair: pair[1])
    return best


def _swap_once(
    state: Neighborhoods, limit: float, band: DensityBand, n_swaps: int, movable: Mask | None
) -> bool:
    """Try one round and do what paid; whether anything was tried."""
    price = _DENSITY_PRICE * float(state.errors.mean()) * len(state.errors) / len(state.kept) or 1.0
    band.start(state.kept, price)
    dropped, added = _candidates(state, limit, band.pull(), n_swaps, movable)
    if not len(added) or not len(dropped):
        return False
    changes = state.try_swap(dropped, added) - state.errors
    costs, gains = _effects(state.points, changes, dropped, added)
    gains[state.gaps[added, 0] > limit] = np.inf
    stay_out, stay_in = choose_swaps(band, dropped, costs, added, gains, price)
    state.swap(dropped[stay_out], added[stay_in])
    return True


def _effects(points: Points, changes: Vector, dropped: Indices, added: Indices) -> tuple[Vector, Vector]:
    """Error that each drop cost and each addition gained: every original counts for its nearest candidate."""
    candidates, rows = np.concatenate([dropped, added]), np.flatnonzero(changes)
    nearest = Neighbors(points[candidates]).query(points[rows], 1)[1][:, 0]
    totals: Vector = np.bincount(nearest, changes[rows], len(candidates)).astype(np.float64)
    return totals[: len(dropped)], -totals[len(dropped) :]


def _candidates(
    state: Neighborhoods, limit: float, pull: Vector, n_wanted: int, movable: Mask | None
) -> tuple[Indices, Indices]:
    """Rows to drop and rows to take on trial, each up to ``n_wanted`` (holes: all), none beside another."""
    owners = state.owners
    mass = np.bincount(owners, weights=state.errors, minlength=len(state.kept))
    reach = np.zeros(len(mass))
    np.maximum.at(reach, owners, state.gaps[:, 1])
    spare = np.flatnonzero(reach <= limit)
    spare = spare if movable is None else spare[movable[state.kept[spare]]]
    blocked = np.zeros(len(mass), dtype=np.bool_)
    worth = mass - pull[state.kept]
    order = spare[np.argsort(worth[spare], kind="stable")[: _LOOK_AHEAD * n_wanted]]
    never = np.zeros(len(order), dtype=np.bool_)
    dropped = state.kept[
        order[_apart(order, state.rings(state.kept[order], _RING), never, blocked, n_wanted)]
    ]
    takeable = np.ones(len(owners), dtype=np.bool_) if movable is None else movable
    worst = _worst_of_each_cell(owners, takeable, state.gaps, state.errors, limit, len(mass))
    holes = state.gaps[worst, 0] > limit
    depth = np.where(holes, state.gaps[worst, 0], 0.0)
    order = np.lexsort((pull[worst] - mass[owners[worst]], -depth))[
        : max(_LOOK_AHEAD * n_wanted, np.count_nonzero(holes))
    ]
    rows = worst[order]
    added = _apart(owners[rows], state.rings(rows, _RING), holes[order], blocked, n_wanted)
    return dropped, rows[added]


@njit(cache=True, nogil=True)
def _apart(cells, rings, forced, blocked, n_wanted):
    """Numbers of the first candidates whose cells are not blocked; each blocks the cells around it."""
    chosen = np.empty(len(cells), np.int64)
    count = 0
    for i in range(len(cells)):
        if not forced[i] and (count >= n_wanted or blocked[cells[i]]):
            continue
        chosen[count] = i
        count += 1
        for neighbor in rings[i]:
            blocked[neighbor] = True
    return chosen[:count]


@njit(cache=True, nogil=True)
def _worst_of_each_cell(owners, takeable, gaps, errors, limit, n_cells):
    """The most urgent original of every cell that may be taken and is not at the place of its kept point."""
    worst, most, above = np.full(n_cells, -1), np.full(n_cells, -1.0), errors.max()
    for i in range(len(owners)):
        if takeable[i] and gaps[i, 0] > 0:
            urgency = above + gaps[i, 0] if gaps[i, 0] > limit else errors[i]
            if urgency > most[owners[i]]:
                worst[owners[i]], most[owners[i]] = i, urgency
    return worst[worst >= 0]
