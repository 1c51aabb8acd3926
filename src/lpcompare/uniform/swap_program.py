"""Which swaps on trial stay: a boolean program over what every drop cost and every addition gained.

With x_j = 1 where candidate j stays, s_j = 1 for an addition and -1 for a drop, g_j what it saved, and
w_j = s_j (C_j - 1), where C_j is eq. 13 as a share of the cluster's density::

    maximise    sum_j g_j x_j - p sum_c (e_c + 30 f_c)
    subject to  sum_j s_j x_j = 0                                           as many come as go
                |S_c + sum_{j in c} w_j x_j| <= t (n_c + sum_{j in c} s_j x_j) + e_c + f_c
                                                                            eqs. 24, 25 for every cluster c
                x_j in {0, 1}, 0 <= e_c <= excess now, f_c >= 0

S_c is the sum of C_i - 1 over the n_c points that the cluster keeps, t the tolerance. Leaving the band costs more
than staying outside it. A candidate that closes a hole has to stay.

Two rows for each of some twenty clusters bind thousands of candidates, so that the linear relaxation leaves few of
them between 0 and 1. These, and those whose reduced cost is least, are the core; HiGHS solves it as a boolean
program, the others being fixed. Pairing the best addition with the first drop that its cluster bears, which was the
rule before, left 4 % of the error at 500,000 points.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.sparse import csc_array

from lpcompare.errors import SolverError
from lpcompare.paper.highs import Program
from lpcompare.types import Indices, Mask, Vector
from lpcompare.uniform.densities import DensityBand

_AT_ONCE = 4_096
_CORE = 32
_FAR = 30.0
_GAP = 0.01
_WHOLE = 1e-6
_MOST_NODES = 10_000
"""Not seconds: a busy machine chooses the same."""
_SIMPLEX = {"solver": "simplex"}
"""The interior point method takes 100 times as long on these programs, and presolving as well."""


def choose_swaps(
    band: DensityBand, dropped: Indices, costs: Vector, added: Indices, gains: Vector, price: float
) -> tuple[Mask, Mask]:
    """Which drops and which additions stay, equally many.

    Parameters
    ----------
    band : DensityBand
        Started with the points kept before the trial. Its prices are those of this program afterwards.
    dropped : ndarray of int, shape (d,)
    costs : ndarray, shape (d,)
        What each drop cost.
    added : ndarray of int, shape (a,)
    gains : ndarray, shape (a,)
        What each addition saved; infinity for one that closes a hole, the most urgent first.
    price : float
        Cost of one point's share by which a density is outside its band.

    Returns
    -------
    stay_out : ndarray of bool, shape (d,)
    stay_in : ndarray of bool, shape (a,)
    """
    n_added, forced = len(added), np.isinf(gains)
    forced[np.flatnonzero(forced)[len(dropped) :]] = False
    values = np.concatenate([np.where(np.isinf(gains), 0.0, gains), -costs])
    scale = float(np.abs(values).mean()) or 1.0
    signs = np.repeat([1.0, -1.0], [n_added, len(dropped)])
    program = _build(band, np.concatenate([added, dropped]), signs, values / scale, price / scale)
    program.columns[0][: len(forced)] = forced
    relaxed, prices = _relax(replace(program, boolean=np.zeros_like(program.boolean)), len(signs))
    band.prices = -scale * prices[1:].reshape(2, -1)
    stays = _round(program, signs, relaxed, np.abs(program.reduced(prices)))
    return stays[n_added:], stays[:n_added]


def _build(band: DensityBand, rows: Indices, signs: Vector, values: Vector, price: float) -> Program:
    """The program: columns x, e, f; rows: the count, upper limits of the clusters, lower limits."""
    labels, weights = band.labels[rows], signs * (band.costs[rows] - 1.0)
    n_clusters, room = len(band.counts), band.tolerance * band.counts
    clusters, n_columns = np.arange(n_clusters), len(rows) + 2 * n_clusters
    slack = -np.ones((2 * n_clusters, 2))
    entries = np.column_stack([signs, weights - band.tolerance * signs, -weights - band.tolerance * signs])
    places = np.column_stack([np.zeros(len(rows)), 1 + labels, 1 + n_clusters + labels])
    both = np.tile(np.column_stack([1 + clusters, 1 + n_clusters + clusters]), (2, 1))
    starts = np.concatenate(
        [3 * np.arange(len(rows) + 1), 3 * len(rows) + 2 * np.arange(1, 2 * n_clusters + 1)]
    )
    matrix = csc_array(
        (
            np.concatenate([entries.ravel(), slack.ravel()]),
            np.concatenate([places.ravel(), both.ravel()]).astype(np.int64),
            starts,
        ),
        shape=(1 + 2 * n_clusters, n_columns),
    )
    excess = np.maximum(np.abs(band.sums) - room, 0.0)
    most = np.concatenate([np.ones(len(rows)), excess, np.full(n_clusters, np.inf)])
    limits = np.concatenate([[0.0], room - band.sums, room + band.sums])
    least = np.concatenate([[0.0], np.full(2 * n_clusters, -np.inf)])
    prices = price * np.repeat([1.0, _FAR], n_clusters)
    return Program(
        np.concatenate([-values, prices]),
        matrix,
        (least, limits),
        (np.zeros(n_columns), most),
        np.arange(n_columns) < len(rows),
    )


def _relax(program: Program, n_candidates: int) -> tuple[Vector, Vector]:
    """Solution and prices of a linear program whose first columns are candidates, from 0 or 1 to 1."""
    if n_candidates > _AT_ONCE:
        with suppress(SolverError):  # a part cannot always make up for the count of the others
            return _sift(program, n_candidates)
    return _solved(program, np.ones(len(program.costs), dtype=np.bool_), np.zeros(len(program.costs)))


def _sift(program: Program, n_candidates: int) -> tuple[Vector, Vector]:
    """`_relax` piece by piece, because the time of HiGHS grows with the square of the columns.

    At the prices that some candidates lead to, which stand for all, most of the others are clearly in or out. They
    are fixed; those that the prices of the rest prove wrong are set free, until there are none and the solution
    is that of the whole.
    """
    (least, most), candidates = program.columns, np.arange(len(program.costs)) < n_candidates
    stride = -(-n_candidates // _AT_ONCE)
    free = ~candidates
    free[:n_candidates:stride] = True
    weights = np.where(candidates, float(stride), 1.0)
    everyone = replace(program, costs=weights * program.costs, matrix=(program.matrix * weights).tocsc())
    reduced = program.reduced(_solved(everyone, free, np.zeros(len(free)))[1])
    free = ~candidates
    free[np.argsort(np.abs(reduced[candidates]), kind="stable")[:_AT_ONCE]] = True
    while True:
        fixed = np.where(candidates, np.where(reduced < 0, most, least), 0.0)
        values, prices = _solved(program, free, fixed)
        reduced = program.reduced(prices)
        wrong = ~free & np.where(values > least, reduced > _WHOLE, (reduced < -_WHOLE) & (values < most))
        if not wrong.any():
            return values, prices
        free |= wrong


def _solved(program: Program, free: Mask, values: Vector) -> tuple[Vector, Vector]:
    """Solution and prices of the columns ``free``, the others being fixed at their ``values``."""
    outcome = program.part(free, values).solve(_SIMPLEX)
    values = values.copy()
    values[free] = outcome.values
    return values, outcome.prices


def _round(program: Program, signs: Vector, values: Vector, reduced: Vector) -> Mask:
    """Solve the core as a boolean program, with the other candidates as the relaxation ``values`` has them."""
    whole = np.append(np.round(values[: len(signs)]), np.zeros(len(values) - len(signs)))
    core = np.ones(len(values), dtype=np.bool_)
    core[: len(signs)] = np.abs(values[: len(signs)] - whole[: len(signs)]) > _WHOLE
    for side in (1.0, -1.0):
        rows = np.flatnonzero(signs == side)
        core[rows[np.argsort(reduced[rows], kind="stable")[:_CORE]]] = True
    gap = _GAP * abs(float(program.costs @ values))
    part = program.part(core, whole)
    outcome = part.solve({"mip_abs_gap": max(gap, 1e-10), "mip_rel_gap": 0.0, "mip_max_nodes": _MOST_NODES})
    whole[core] = np.round(outcome.values)
    return whole[: len(signs)] > 0
