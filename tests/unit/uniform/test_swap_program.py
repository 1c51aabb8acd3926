"""What the program of the swaps chooses, against every choice there is."""

from dataclasses import replace
from itertools import product
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.uniform import swap_program
from lpcompare.uniform.densities import DensityBand
from lpcompare.uniform.swap_program import choose_swaps

PRICE = 0.5


def instance(seed, n_dropped, n_added, n_clusters, tolerance):
    """A band with forty kept points, and candidates with costs and gains."""
    rng = np.random.default_rng(seed)
    n = 40 + n_dropped + n_added
    band = DensityBand(rng.integers(0, n_clusters, n), rng.uniform(0.5, 1.5, n), tolerance)
    band.start(np.arange(40 + n_dropped), PRICE)
    dropped, added = 40 + np.arange(n_dropped), 40 + n_dropped + np.arange(n_added)
    return band, dropped, rng.normal(0.2, 1, n_dropped), added, rng.normal(0.2, 1, n_added)


def excess(band, stay_out, dropped, stay_in, added):
    """How far every cluster's sum lies outside its band after the swaps."""
    rows = np.concatenate([dropped[stay_out], added[stay_in]])
    signs = np.repeat([-1.0, 1.0], [stay_out.sum(), stay_in.sum()])
    n_clusters, labels = len(band.counts), band.labels[rows]
    counts = band.counts + np.bincount(labels, signs, n_clusters)
    sums = band.sums + np.bincount(labels, signs * (band.costs[rows] - 1), n_clusters)
    return np.maximum(np.abs(sums) - band.tolerance * counts, 0)


def value(band, dropped, costs, added, gains, stay_out, stay_in):
    """What the swaps save, less the price of what lies outside the band."""
    after = excess(band, stay_out, dropped, stay_in, added)
    before = excess(band, np.zeros_like(stay_out), dropped, np.zeros_like(stay_in), added)
    price = PRICE * (np.minimum(after, before) + 30 * np.maximum(after - before, 0)).sum()
    return gains[stay_in].sum() - costs[stay_out].sum() - price


@given(
    seed=st.integers(0, 2**32 - 1),
    sizes=st.tuples(st.integers(1, 5), st.integers(1, 5), st.integers(1, 3)),
    tolerance=st.sampled_from([0.0, 0.01, 0.1]),
)
@settings(max_examples=40, deadline=None)
def test_no_choice_is_much_better(seed, sizes, tolerance):
    band, dropped, costs, added, gains = instance(seed, *sizes, tolerance)
    stay_out, stay_in = choose_swaps(band, dropped, costs, added, gains, PRICE)
    assert stay_out.sum() == stay_in.sum()
    found = value(band, dropped, costs, added, gains, stay_out, stay_in)
    best = -np.inf
    for bits in product([False, True], repeat=len(dropped) + len(added)):
        out, into = np.array(bits[: len(dropped)]), np.array(bits[len(dropped) :])
        if out.sum() == into.sum():
            best = max(best, value(band, dropped, costs, added, gains, out, into))
    relaxed = np.abs(costs).sum() + np.abs(gains).sum() + PRICE * 40
    assert found >= best - 0.01 * relaxed


@given(
    seed=st.integers(0, 2**32 - 1),
    sizes=st.tuples(st.integers(1, 30), st.integers(1, 30), st.integers(1, 3)),
    tolerance=st.sampled_from([0.0, 0.01, 0.1]),
    n_values=st.integers(1, 40),
    at_once=st.integers(1, 20),
)
@settings(max_examples=60, deadline=None)
def test_solved_piece_by_piece_a_relaxation_is_that_of_the_whole(seed, sizes, tolerance, n_values, at_once):
    """Few different values make ties."""
    band, dropped, _, added, _ = instance(seed, *sizes, tolerance)
    rows, signs = np.concatenate([added, dropped]), np.repeat([1.0, -1.0], [len(added), len(dropped)])
    worth = np.random.default_rng(seed).integers(-n_values, n_values, len(rows)).astype(float)
    program = swap_program._build(band, rows, signs, worth, PRICE)
    program.columns[0][: min(len(added), len(dropped), 2)] = 1.0
    program = replace(program, boolean=np.zeros_like(program.boolean))
    with patch.object(swap_program, "_AT_ONCE", at_once):
        values, _ = swap_program._relax(program, len(rows))
    whole = program.solve({"solver": "simplex"}).values
    assert program.costs @ values == pytest.approx(program.costs @ whole, abs=1e-4)
    least, most = program.rows
    assert (program.matrix @ values >= least - 1e-6).all()
    assert (program.matrix @ values <= most + 1e-6).all()


@pytest.mark.parametrize("n_added", [3, 9])
def test_what_closes_a_hole_stays_as_far_as_there_are_drops(n_added):
    band, dropped, costs, added, gains = instance(1, 4, n_added, 2, 0.0)
    gains[:] = np.inf
    stay_out, stay_in = choose_swaps(band, dropped, costs, added, gains, PRICE)
    assert stay_in.sum() == stay_out.sum() == min(n_added, 4)
    assert stay_in[: min(n_added, 4)].all()


def test_thousands_of_candidates_keep_the_band_and_lose_little():
    """Against the relaxation, which no choice can beat."""
    rng = np.random.default_rng(0)
    n, labels = 20_000, np.arange(20_000) % 20
    band = DensityBand(labels, 1 + rng.normal(0, 0.3, n), 0.001)
    band.start(np.arange(16_000), PRICE)
    dropped, added = np.arange(12_000, 16_000), np.arange(16_000, n)
    band.sums[:] = 0.0
    costs, gains = rng.normal(0.2, 1, 4000), rng.normal(0.2, 1, 4000) + 0.5 * (band.costs[added] - 1)
    stay_out, stay_in = choose_swaps(band, dropped, costs, added, gains, PRICE)
    assert stay_out.sum() == stay_in.sum()
    assert excess(band, stay_out, dropped, stay_in, added).max() < 1e-9
    prices, weights = band.prices, band.costs - 1
    saved = gains[stay_in].sum() - costs[stay_out].sum()
    toward = (prices[0] - prices[1])[labels] * weights - band.tolerance * prices.sum(axis=0)[labels]
    worth = np.concatenate([gains - toward[added], toward[dropped] - costs])
    signs = np.repeat([1.0, -1.0], 4000)
    counts = [np.maximum(worth - level * signs, 0).sum() for level in np.linspace(-2, 2, 401)]
    bound = min(counts) + (band.tolerance * band.counts * prices.sum(axis=0)).sum()
    assert saved > 0.99 * bound
