"""`lp_graph`: brute force, bounds that hold for every selection, swaps and tiles that never cost more."""

from itertools import combinations

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lpcompare.errors import InputError
from lpcompare.methods.lp_graph import lp_graph
from lpcompare.uniform.annealing import anneal
from lpcompare.uniform.local_density import LocalDensity, relax
from lpcompare.uniform.local_program import build_program, solve_tiles

SETTINGS = {"n_neighbors": 6, "wanted": 2, "price": 0.3, "hole_price": 1.0}


def bumpy_sheet(n, seed=0):
    x, y = np.random.default_rng(seed).random((2, n))
    return np.column_stack([x, y, 0.1 * np.abs(x - 0.5)])


def selection(n, n_keep, seed):
    mask = np.zeros(n, dtype=bool)
    mask[np.random.default_rng(seed).permutation(n)[:n_keep]] = True
    return mask


def by_hand(program, mask):
    """The objective from its definition."""
    total = 0.0
    for i, hood in enumerate(program.hoods):
        total += 0.0 if mask[i] else program.features[i]
        y = abs(int(mask[hood].sum()) - program.wanted)
        total += program.price * y + program.hole_price * max(y - 1, 0)
    return total


def cheapest(program):
    n = len(program.features)
    masks = (np.isin(np.arange(n), c) for c in combinations(range(n), program.n_keep))
    return min(by_hand(program, mask) for mask in masks)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(2, 11), share=st.floats(0, 1), wanted=st.integers(1, 3))
def test_a_small_cloud_gets_the_selection_that_brute_force_finds(seed, n, share, wanted):
    points, n_keep = bumpy_sheet(n, seed), 1 + int(share * (n - 1))
    own = SETTINGS | {"wanted": wanted}
    result = lp_graph(points, n_keep, rng=np.random.default_rng(0), n_trials=1, **own)
    program = LocalDensity.over(points, n_keep, **own)
    mask = np.isin(np.arange(n), result.indices)
    (certificate,) = result.info["certificates"]
    assert by_hand(program, mask) == pytest.approx(cheapest(program), abs=1e-6)
    assert certificate.cost == pytest.approx(by_hand(program, mask))
    assert certificate.proven
    assert certificate.gap <= 1e-5


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    multipliers=arrays(float, 10, elements=st.floats(-1.3, 1.3)),
    n_keep=st.integers(1, 10),
)
def test_the_bound_of_any_multipliers_is_below_the_cheapest_selection(seed, multipliers, n_keep):
    program = LocalDensity.over(bumpy_sheet(10, seed), n_keep, **SETTINGS)
    assert program.bound(multipliers) <= cheapest(program) + 1e-9


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), multipliers=arrays(float, 40, elements=st.floats(-1.3, 1.3)))
def test_the_parts_of_the_gap_are_not_negative_and_add_up(seed, multipliers):
    program = LocalDensity.over(bumpy_sheet(40, seed), 12, **SETTINGS)
    mask = selection(40, 12, seed)
    parts = program.gaps(mask, multipliers)
    assert parts.min() >= -1e-9
    assert parts.sum() == pytest.approx(program.cost(mask) - program.bound(multipliers))
    assert program.cost(mask) == pytest.approx(by_hand(program, mask))


def test_the_relaxation_is_closed_by_its_own_bound():
    program = LocalDensity.over(bumpy_sheet(1500), 300, **SETTINGS)
    shares, multipliers = relax(program)
    assert shares.sum() == pytest.approx(300, abs=1e-3)
    assert np.abs(multipliers).max() <= program.price + program.hole_price
    assert program.bound(multipliers) <= program.cost(shares) + 1e-9
    assert program.bound(multipliers) >= 0.99 * program.cost(shares)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), n_keep=st.integers(1, 300))
def test_swaps_keep_the_count_and_never_cost_more(seed, n_keep):
    program = LocalDensity.over(bumpy_sheet(300, seed), n_keep, **SETTINGS)
    start = selection(300, n_keep, seed)
    better = anneal(program, start, 5, np.random.default_rng(seed))
    assert better.sum() == n_keep
    assert by_hand(program, better) <= by_hand(program, start) + 1e-9
    assert start.sum() == n_keep, "the start was changed"


def test_swaps_leave_no_single_one_that_saves_anything():
    program = LocalDensity.over(bumpy_sheet(60), 20, **SETTINGS)
    mask = anneal(program, selection(60, 20, 1), 10, np.random.default_rng(0))
    for out in np.flatnonzero(mask):
        for into in program.hoods[out][~mask[program.hoods[out]]]:
            other = mask.copy()
            other[[out, into]] = False, True
            assert by_hand(program, other) >= by_hand(program, mask) - 1e-6


def test_the_program_of_a_tile_counts_what_changes_in_the_cloud():
    program = LocalDensity.over(bumpy_sheet(90), 30, **SETTINGS)
    mask, tile = selection(90, 30, 2), np.arange(20, 45)
    problem, variables = build_program(program, tile, mask)
    x, y, e = variables
    costs = []
    for seed in range(4):
        mask[tile] = selection(25, int(mask[tile].sum()), seed)
        fixed = cp.Problem(problem.objective, [*problem.constraints, x == mask[tile].astype(float)])
        costs.append((fixed.solve(solver=cp.HIGHS), program.cost(mask)))
    inside, whole = np.array(costs).T
    assert np.ptp(whole) > 0.1
    assert np.diff(inside) == pytest.approx(np.diff(whole), abs=1e-5)
    assert len(y.value) == len(e.value)


def test_tiles_never_cost_more_and_say_what_is_proven():
    points = bumpy_sheet(1200)
    program = LocalDensity.over(points, 240, **SETTINGS)
    _, multipliers = relax(program)
    mask, told = selection(1200, 240, 0), []
    better, certificate = solve_tiles(
        program,
        points,
        mask,
        multipliers,
        n_tiles=3,
        tolerance=1e-3,
        time_limit=10.0,
        progress=lambda done, total: told.append((done, total)),
    )
    assert better.sum() == 240
    assert program.cost(better) < program.cost(mask)
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert certificate.proof == "relaxation"
    assert certificate.bound <= certificate.cost == pytest.approx(by_hand(program, better))
    kept = program.members @ better.astype(float)
    assert (certificate.n_empty, certificate.largest_miss) == ((kept == 0).sum(), np.abs(kept - 2).max())
    assert not certificate.proven


def test_a_sheet_is_thinned_without_holes_to_a_small_proven_gap():
    points = bumpy_sheet(4000)
    result = lp_graph(points, 400, rng=np.random.default_rng(0))
    (certificate,) = result.info["certificates"]
    assert certificate.gap <= 0.05
    assert certificate.n_empty <= 0.01 * 4000
    program = LocalDensity.over(points, 400, **SETTINGS)
    kept = program.members @ np.isin(np.arange(4000), result.indices).astype(float)
    at_random = program.members @ selection(4000, 400, 0).astype(float)
    assert kept.var() < 0.5 * at_random.var()
    assert program.features[result.indices].mean() > 1.5, "the mean feature is 1"


@pytest.mark.parametrize(
    "wrong", [{"wanted": 0}, {"price": -1.0}, {"n_trials": -1}, {"n_tiles": -1}, {"n_neighbors": 0}]
)
def test_a_wrong_setting_is_named(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        lp_graph(bumpy_sheet(200), 50, rng=np.random.default_rng(0), **wrong)
