"""A good selection for the program of `lp_graph`: swaps of neighbors, at first also some that cost.

A swap drops a kept point and keeps another point of its neighborhood; it changes two neighborhoods' counts per
membership, so that its cost takes some 2 K additions. Swaps that raise the cost by d are made with probability
exp(-d / T) (Kirkpatrick, Gelatt and Vecchi 1983), T falling from .5 to .02 mean features; at the end the best
swap of each point is made as long as it saves something.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.checks import check_integer
from lpcompare.types import Indices, Mask, Vector
from lpcompare.uniform.local_density import LocalDensity

_HOT, _COLD = 0.5, 0.02
_SWEEPS = 30


def anneal(program: LocalDensity, mask: Mask, n_trials: int, rng: np.random.Generator) -> Mask:
    """Improve a selection by swaps.

    Parameters
    ----------
    program : LocalDensity
    mask : ndarray of bool, shape (n,)
        A selection of ``n_keep`` points.
    n_trials : int
        Swaps that are tried with a temperature, per point of the cloud.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of bool, shape (n,)
        A selection of as many points, which costs no more.

    Raises
    ------
    InputError
        ``n_trials`` is not an integer of at least 0.
    """
    n_trials, owners = check_integer("n_trials", n_trials, 0), program.owners
    kept = (program.members @ mask.astype(float)).astype(np.int64)
    starts, rows = owners.indptr.astype(np.intp), owners.indices.astype(np.intp)
    state = program.hoods, starts, rows, program.features, mask.copy(), kept
    prices = program.wanted, program.price, program.hole_price
    if program.hoods.shape[1] > 1:
        _swap_at_random(state, prices, n_trials * len(mask), rng)
        _swap_best(state, prices)
    return min(mask, state[4], key=program.cost)


_State = tuple[NDArray[np.intp], Indices, Indices, Vector, Mask, Indices]
"""Neighborhoods, starts and rows of the neighborhoods that each point is in, features, selection, counts."""
_Prices = tuple[int, float, float]


@njit(cache=True)
def _swap_at_random(state: _State, prices: _Prices, n_trials: int, rng: np.random.Generator) -> None:
    hoods, _, _, features, mask, _ = state
    chosen = np.flatnonzero(mask)
    for trial in range(n_trials):
        temperature = _HOT * (_COLD / _HOT) ** (trial / n_trials)
        place = int(rng.random() * len(chosen))
        out = chosen[place]
        into = hoods[out, 1 + int(rng.random() * (hoods.shape[1] - 1))]
        if mask[into]:
            continue
        cost = features[out] - features[into]
        cost += _change(state, prices, out, -1)
        cost += _change(state, prices, into, 1)
        if cost <= 0 or rng.random() < np.exp(-cost / temperature):
            mask[out], mask[into], chosen[place] = False, True, into
        else:
            _change(state, prices, out, 1)
            _change(state, prices, into, -1)


@njit(cache=True)
def _swap_best(state: _State, prices: _Prices) -> None:
    hoods, _, _, features, mask, _ = state
    for _ in range(_SWEEPS):
        n_swaps = 0
        for out in range(len(mask)):
            if not mask[out]:
                continue
            gain = features[out] + _change(state, prices, out, -1)
            best, least = out, -1e-9
            for into in hoods[out]:
                if mask[into]:
                    continue
                cost = gain - features[into] + _change(state, prices, into, 1)
                _change(state, prices, into, -1)
                if cost < least:
                    best, least = into, cost
            _change(state, prices, best, 1)
            if best != out:
                mask[out], mask[best] = False, True
                n_swaps += 1
        if n_swaps == 0:
            break


@njit(cache=True)
def _change(state: _State, prices: _Prices, point: int, by: int) -> float:
    """Count a point in (by = 1) or out (-1) where it is a member; return what that costs."""
    _, starts, rows, _, _, kept = state
    wanted, price, hole_price = prices
    cost = 0.0
    for place in range(starts[point], starts[point + 1]):
        before = abs(kept[rows[place]] - wanted)
        kept[rows[place]] += by
        after = abs(kept[rows[place]] - wanted)
        cost += price * (after - before) + hole_price * (max(after - 1, 0) - max(before - 1, 0))
    return cost  # pyright: ignore[reportReturnType]
