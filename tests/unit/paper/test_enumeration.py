"""Counting every sum against counting every subset."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare.paper.enumeration import nearest_sum


@given(n_points=st.integers(1, 11), seed=st.integers(0, 9999), ties=st.booleans(), data=st.data())
def test_no_subset_is_nearer(n_points, seed, ties, data):
    n_keep = data.draw(st.integers(1, n_points))
    target = data.draw(st.floats(0, 4))
    costs = np.random.default_rng(seed).uniform(0.2, 3, n_points)
    costs = np.round(costs) if ties else np.rint(costs * 2**36) / 2**36
    mask = nearest_sum(costs, n_keep, target)
    subsets = combinations(range(n_points), n_keep)
    best = min(abs(costs[list(rows)].mean() - target) for rows in subsets)
    assert mask.sum() == n_keep
    assert abs(costs[mask].mean() - target) == pytest.approx(best, abs=1e-9)


def test_many_equal_costs_are_few_sums():
    costs = np.repeat([0.5, 1.0, 1.75], 200)
    mask = nearest_sum(costs, 111, 1.01)
    assert mask.sum() == 111
    assert abs(costs[mask].mean() - 1.01) <= 0.25 / 111 / 2


def test_too_many_sums_are_declined():
    assert nearest_sum(np.random.default_rng(0).uniform(size=400), 200, 0.5) is None
