"""The best selection of a small cluster by counting: no subset sum is left out, so it is a proof.

The costs are split in two halves; the sums that each half can give are listed by how many points make them,
and the nearest pair of sums is found (Horowitz and Sahni, JACM 21(2), 1974). Equal sums are listed once, so
that clusters with many equal distances are small too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Indices, Mask, Vector

_STEP = 2.0**-36
_MOST_SUMS = 1_000_000

Sums = list[NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class _Half:
    """One half of the costs: ``levels[i][m]`` holds the sums of m of its first i points, ascending."""

    rows: Indices
    costs: NDArray[np.int64]
    levels: list[Sums]

    def choice(self, n_chosen: int, total: int) -> list[int]:
        """Rows of ``n_chosen`` points that add up to ``total``."""
        rows = []
        for i in reversed(range(len(self.costs))):
            known = self.levels[i][n_chosen] if n_chosen < len(self.levels[i]) else np.empty(0, np.int64)
            at = int(np.searchsorted(known, total))
            if at == len(known) or known[at] != total:
                rows.append(int(self.rows[i]))
                n_chosen, total = n_chosen - 1, total - int(self.costs[i])
        return rows


def nearest_sum(costs: Vector, n_keep: int, target: float) -> Mask | None:
    """The selection whose mean cost is nearest to ``target``, where counting every sum is affordable.

    Parameters
    ----------
    costs : ndarray, shape (n,)
        Counted in steps of 2^-36.
    n_keep : int
        From 1 to n.
    target : float
        Mean cost to reach.

    Returns
    -------
    ndarray of bool, shape (n,), or None
        None where a half has too many sums.
    """
    if n_keep > len(costs) / 2:
        n_drop = len(costs) - n_keep
        left_out = (float(costs.sum()) - target * n_keep) / n_drop if n_drop else 0.0
        dropped = nearest_sum(costs, n_drop, left_out) if n_drop else np.zeros(len(costs), dtype=bool)
        return None if dropped is None else ~dropped
    whole = np.rint(costs / _STEP).astype(np.int64)
    halves = [_list_sums(whole, np.arange(side, len(costs), 2), n_keep) for side in (0, 1)]
    if halves[0] is None or halves[1] is None:
        return None
    return _nearest_pair(halves[0], halves[1], n_keep, round(target * n_keep / _STEP), len(costs))


def _list_sums(costs: NDArray[np.int64], rows: Indices, most: int) -> _Half | None:
    """Every sum of up to ``most`` of the points ``rows``, or None where they are too many."""
    levels: list[Sums] = [[np.zeros(1, dtype=np.int64)]]
    for row in rows:
        before = levels[-1]
        after = [before[0]]
        for m in range(1, min(len(before), most) + 1):
            grown = before[m - 1] + costs[row]
            after.append(_union(before[m], grown) if m < len(before) else grown)
        if sum(map(len, after)) > _MOST_SUMS:
            return None
        levels.append(after)
    return _Half(rows, costs[rows], levels)


def _union(left: NDArray[np.int64], right: NDArray[np.int64]) -> NDArray[np.int64]:
    """Distinct values of both, ascending."""
    merged = np.sort(np.concatenate([left, right]))
    return merged[np.append(True, merged[1:] != merged[:-1])]


def _nearest_pair(left: _Half, right: _Half, n_keep: int, wanted: int, n_points: int) -> Mask:
    best: tuple[int, list[int]] | None = None
    for m, sums in enumerate(left.levels[-1]):
        if not 0 <= n_keep - m < len(right.levels[-1]):
            continue
        partners = right.levels[-1][n_keep - m]
        at = np.searchsorted(partners, wanted - sums)
        for near in (np.maximum(at - 1, 0), np.minimum(at, len(partners) - 1)):
            misses = np.abs(sums + partners[near] - wanted)
            i = int(np.argmin(misses))
            if best is None or int(misses[i]) < best[0]:
                rows = left.choice(m, int(sums[i])) + right.choice(n_keep - m, int(partners[near[i]]))
                best = int(misses[i]), rows
    mask = np.zeros(n_points, dtype=bool)
    mask[best[1] if best else []] = True
    return mask
