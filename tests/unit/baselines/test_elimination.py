"""The loop that removes the least important point, against one that looks at everything each time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from lpcompare_baselines._elimination import SIGNATURE, eliminate


@njit(SIGNATURE, cache=True)
def spread(row, hood, points, data):
    total = data[row, 0]
    for other in hood:
        for c in range(3):
            total += abs(points[other, c] - points[row, c])
    return total


def plain(points, target, k, data, fixed):
    """Every neighborhood and every importance anew, before each removal."""
    left, removed = list(range(len(points))), []
    while len(left) > target:
        worth = []
        for row in left:
            others = [o for o in left if o != row]
            distances = np.linalg.norm(points[others] - points[row], axis=1)
            hood = np.array(others)[np.argsort(distances, kind="stable")[:k]]
            worth.append((np.inf if fixed[row] else spread(row, hood, points, data), row))
        row = min(worth)[1]
        left.remove(row)
        removed.append(row)
    return removed


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 70), k=st.integers(1, 9), rest=st.integers(1, 69))
def test_order_of_removal_is_that_of_the_plain_loop(seed, n, k, rest):
    rng = np.random.default_rng(seed)
    points, data = rng.normal(size=(n, 3)), rng.exponential(0.2, (n, 1))
    target = min(rest, n - 1)
    fixed = np.zeros(n, bool)
    fixed[rng.choice(n, target // 2, replace=False)] = True
    result = eliminate(points, target, spread, k, data=data, fixed=fixed)
    assert result.removed.tolist() == plain(points, target, k, data, fixed)
    assert sorted([*result.kept, *result.removed]) == list(range(n))
    assert fixed[result.kept].sum() == target // 2


def test_a_longer_run_begins_with_the_shorter_one():
    points = np.random.default_rng(0).normal(size=(3000, 3))
    long, short = (eliminate(points, m, spread, 6, data=np.zeros((3000, 1))) for m in (200, 1500))
    assert np.array_equal(long.removed[:1500], short.removed)


@pytest.mark.parametrize("place", [np.zeros(3), np.array([5e5, 4e6, 300.0])])
def test_even_thins_a_plane_evenly_where_importance_says_nothing(place):
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.random((4000, 2)), np.zeros(4000)]) + place

    kept = eliminate(points, 400, nothing, 6, even=True).kept
    nearest = np.sort(np.linalg.norm(points[kept][:, None] - points[kept], axis=2), axis=1)[:, 1]
    assert nearest.std() / nearest.mean() < 0.35


@njit(SIGNATURE, cache=True)
def nothing(row, hood, points, data):
    return 0.0


def test_even_empties_no_place():
    """Half of a plane is worth more than the other: the other keeps a quarter of the mean density at least."""
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.random((4000, 2)), np.zeros(4000)])
    data = (points[:, :1] > 0.5).astype(float)
    kept = eliminate(points, 400, given_worth, 6, data=data, even=True).kept
    assert 50 < (points[kept, 0] < 0.5).sum() < 110


@njit(SIGNATURE, cache=True)
def given_worth(row, hood, points, data):
    return data[row, 0]
