"""One point per cell: the program against brute force, and what its certificate says."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.uniform.program import _EXCESS_PRICE, Stop, select_one_per_cell

EXACT = Stop(gap=0.0)


def instance(seed, n_cells=4, size=4):
    rng = np.random.default_rng(seed)
    cells = np.repeat(np.arange(n_cells), size)
    inverse = rng.random(n_cells * size) + 0.5
    return rng.random(n_cells * size), cells, inverse / inverse.mean()


def brute_force(costs, cells, inverse, tolerance):
    """The least objective over every choice, in units of the cheapest."""
    groups = [np.flatnonzero(cells == c) for c in range(cells.max() + 1)]
    cheapest = sum(costs[g].min() for g in groups)
    return min(
        costs[list(rows)].sum() / cheapest
        + _EXCESS_PRICE * max(abs(inverse[list(rows)].mean() - 1) - tolerance, 0)
        for rows in product(*groups)
    )


@given(seed=st.integers(0, 2**32 - 1), tolerance=st.sampled_from([0.0, 0.01, 0.2]))
@settings(max_examples=25, deadline=None)
def test_finds_what_brute_force_finds_and_never_claims_more(seed, tolerance):
    costs, cells, inverse = instance(seed)
    best = brute_force(costs, cells, inverse, tolerance)
    mask, certificate = select_one_per_cell(costs, cells, inverse, tolerance=tolerance, stop=EXACT)
    assert np.array_equal(np.bincount(cells[mask]), np.ones(4))
    assert certificate.cost == pytest.approx(best, rel=1e-6)
    assert certificate.bound <= best * (1 + 1e-6)
    assert certificate.reduced_density == pytest.approx(inverse[mask].mean())
    assert certificate.residual == pytest.approx(abs(inverse[mask].mean() - 1))


def test_a_wide_tolerance_leaves_the_cheapest_choice():
    costs, cells, inverse = instance(1, 30, 6)
    mask, certificate = select_one_per_cell(costs, cells, inverse, tolerance=1.0, stop=EXACT)
    assert costs[mask].sum() == pytest.approx(costs.reshape(30, 6).min(axis=1).sum())
    assert certificate.cost == pytest.approx(1.0)
    assert certificate.proven


def test_the_density_is_kept_where_it_can_be():
    costs, cells, inverse = instance(2, 60, 5)
    costs += 3 * inverse  # the cheap candidates are the far ones
    free, _ = select_one_per_cell(costs, cells, inverse, tolerance=1.0, stop=Stop())
    _, certificate = select_one_per_cell(costs, cells, inverse, tolerance=0.01, stop=Stop())
    assert abs(inverse[free].mean() - 1) > 0.1
    assert certificate.residual <= 0.0101
    assert certificate.proven


def test_a_density_out_of_reach_is_missed_by_as_little_as_can_be():
    costs, cells, inverse = instance(3, 10, 3)
    _, certificate = select_one_per_cell(costs, cells, 2 * inverse, tolerance=0.01, stop=Stop(gap=1e-9))
    lowest = np.sort(2 * inverse.reshape(10, 3), axis=1)[:, 0].mean()
    assert certificate.reduced_density == pytest.approx(max(lowest, 1.01), abs=2e-2)
    assert certificate.proven


def test_free_candidates_and_single_candidates_are_no_special_case():
    mask, certificate = select_one_per_cell(
        np.zeros(3), np.array([0, 1, 2]), np.ones(3), tolerance=0.01, stop=Stop()
    )
    assert mask.all()
    assert certificate.gap == 0.0
    assert certificate.n_keep == 3
