"""A starting solution for the boolean program: spread over the costs, then improved by exchanges of two."""

from __future__ import annotations

import numpy as np

from lpcompare.paper.enumeration import nearest_sum
from lpcompare.types import Indices, Mask, Vector

_EXCHANGES = 50
_FEW = 12
_MANY = 200


def starting_mask(costs: Vector, n_keep: int, target: float, rng: np.random.Generator) -> Mask:
    """Choose ``n_keep`` points whose mean cost is near ``target``.

    Parameters
    ----------
    costs : ndarray, shape (n,)
    n_keep : int
        From 1 to n.
    target : float
        Mean cost to reach.
    rng : numpy.random.Generator
        Draws one point from each stratum of the sorted costs.

    Returns
    -------
    ndarray of bool, shape (n,)
        The best choice by sorting alone where no choice can reach the target.
    """
    order = np.argsort(costs, kind="stable")
    ranks = _shifted(costs[order], one_per_stratum(len(costs), n_keep, rng), target)
    mask = np.zeros(len(costs), dtype=bool)
    mask[order[ranks]] = True
    return exchange(costs, mask, target)


def one_per_stratum(n_ranks: int, n_strata: int, rng: np.random.Generator) -> Indices:
    """One rank from each of ``n_strata`` nearly equal parts of 0 .. n_ranks - 1, ascending."""
    edges = np.arange(n_strata + 1) * n_ranks // max(n_strata, 1)
    return edges[:-1] + (rng.random(n_strata) * np.diff(edges)).astype(np.intp)


def _shifted(ordered: Vector, ranks: Indices, target: float) -> Indices:
    """Swap the first (or last) chosen ranks for the cheapest (dearest) ones until the target is passed.

    The first t of the cheapest ranks and the chosen ranks after the t-th are distinct: each step is a choice.
    """
    n_keep = len(ranks)
    missing = target * n_keep - float(ordered[ranks].sum())
    extreme = np.arange(n_keep) if missing < 0 else np.arange(len(ordered) - n_keep, len(ordered))
    changes = np.cumsum(np.abs(ordered[extreme] - ordered[ranks])[:: 1 if missing < 0 else -1])
    n_moved = int(np.searchsorted(changes, abs(missing)))
    moved = slice(0, n_moved) if missing < 0 else slice(n_keep - n_moved, n_keep)
    ranks = ranks.copy()
    ranks[moved] = extreme[moved]
    return ranks


def exchange(costs: Vector, mask: Mask, target: float) -> Mask:
    """Exchange one kept point for one other, the best pair each time, while the mean cost nears the target.

    Parameters
    ----------
    costs : ndarray, shape (n,)
    mask : ndarray of bool, shape (n,)
        The choice to improve; it is not changed.
    target : float
        Mean cost to reach.

    Returns
    -------
    ndarray of bool, shape (n,)
        As many points as ``mask``.
    """
    order = np.argsort(costs, kind="stable")
    mask = mask.copy()
    for _ in range(_EXCHANGES):
        inside, outside = order[mask[order]], order[~mask[order]]
        missing = target * len(inside) - float(costs[inside].sum())
        if missing == 0 or not len(outside):
            break
        drop, add = _best_pair(costs, inside, outside, missing)
        if abs(missing - (costs[add] - costs[drop])) >= abs(missing):
            break
        mask[drop], mask[add] = False, True
    return mask


def rearrange(costs: Vector, mask: Mask, target: float, turn: int) -> Mask:
    """Choose anew, and optimally, among a few kept and a few other points, spread over the costs.

    The arguments and the result are those of `exchange`; each ``turn`` takes other points.
    """
    order = np.argsort(costs, kind="stable")
    inside, outside = order[mask[order]], order[~mask[order]]
    kept = _spread(inside, _FEW, turn)
    others = _spread(outside, max(_FEW, _MANY // len(kept)), turn)
    few = np.concatenate([kept, others])
    fixed = float(costs[inside].sum()) - float(costs[kept].sum())
    chosen = nearest_sum(costs[few], len(kept), (target * len(inside) - fixed) / len(kept))
    if chosen is None:
        return mask
    mask = mask.copy()
    mask[few] = chosen
    return mask


def _spread(rows: Indices, most: int, turn: int) -> Indices:
    """Up to ``most`` of the rows, evenly spaced, each ``turn`` one place further on."""
    n_rows = min(len(rows), most)
    return rows[(np.arange(n_rows) * len(rows) // max(n_rows, 1) + turn) % max(len(rows), 1)]


def _best_pair(costs: Vector, inside: Indices, outside: Indices, missing: float) -> tuple[int, int]:
    """The pair (drop, add) whose difference of costs comes nearest to ``missing``."""
    wanted, offered = costs[inside] + missing, costs[outside]
    right = np.clip(np.searchsorted(offered, wanted), 1, max(len(offered) - 1, 1))
    near = np.stack([right - 1, np.minimum(right, len(offered) - 1)])
    misfit = np.abs(offered[near] - wanted)
    side, pair = np.unravel_index(int(np.argmin(misfit)), misfit.shape)
    return int(inside[pair]), int(outside[near[side, pair]])
