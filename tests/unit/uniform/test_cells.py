"""Weights, tilt and blue-noise cells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.uniform.cells import (
    bisect,
    blue_noise_centers,
    nearest_centers,
    sampling_weights,
    tilt_to_density,
)


@given(
    seed=st.integers(0, 2**32 - 1),
    n_points=st.integers(1, 150),
    share=st.floats(0, 1),
    distinct=st.integers(1, 150),
)
@settings(max_examples=60, deadline=None)
def test_bisection_gives_every_cell_a_point(seed, n_points, share, distinct):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(distinct, 3))[rng.integers(distinct, size=n_points)]
    n_cells = max(1, round(share * n_points))
    cells = bisect(points, rng.random(n_points) + 0.01, n_cells)
    assert np.array_equal(np.unique(cells), np.arange(n_cells))


def test_cells_of_a_power_of_two_weigh_the_same():
    points = np.random.default_rng(0).random((4096, 3))
    sizes = np.bincount(bisect(points, np.ones(4096), 64))
    assert (sizes == 64).all()


def test_centers_are_spread_more_evenly_than_random_points():
    points = np.random.default_rng(0).random((5000, 3)) * [1, 1, 0]
    centers = blue_noise_centers(Neighbors(points), np.ones(5000), 300)
    gaps = Neighbors(centers).query(centers, 2)[0][:, 1]
    random_gaps = Neighbors(points[:300]).query(points[:300], 2)[0][:, 1]
    assert gaps.min() > 8 * random_gaps.min()
    assert gaps.std() / gaps.mean() < 0.25


def test_heavier_regions_get_more_cells():
    points = np.random.default_rng(0).random((4000, 3)) * [1, 1, 0]
    tree = Neighbors(points)
    heavy = tree.sorted_points[:, 0] > 0.5
    centers = blue_noise_centers(tree, np.where(heavy, 4.0, 1.0), 200)
    assert np.mean(centers[:, 0] > 0.5) == pytest.approx(0.8, abs=0.05)


def test_weights_are_positive_and_flat_regions_keep_a_share():
    weights = sampling_weights(np.array([0.0, 1.0, 1.0, 4.0]), np.array([0.0, 0.0, 100.0, 0.0]))
    assert (weights > 0).all()
    assert weights[2] > weights[1] > 0.1 * weights[2]
    assert (sampling_weights(np.zeros(3), np.zeros(3)) == 1).all()


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_tilted_weights_keep_the_mean_cost_and_the_weight_of_each_cluster(seed):
    rng = np.random.default_rng(seed)
    labels = rng.integers(3, size=900)
    costs = rng.random(900) + 0.3
    costs /= (np.bincount(labels, costs) / np.bincount(labels))[labels]
    weights = rng.random(900) + 0.1
    tilted = tilt_to_density(weights, costs, labels)
    assert np.bincount(labels, tilted) == pytest.approx(np.bincount(labels, weights))
    assert np.bincount(labels, tilted * costs) / np.bincount(labels, tilted) == pytest.approx(np.ones(3))


@given(seed=st.integers(0, 2**32 - 1), n_points=st.integers(1, 400), n_centers=st.integers(1, 60))
@settings(max_examples=40, deadline=None)
def test_owners_are_the_nearest_centers_whatever_they_were(seed, n_points, n_centers):
    rng = np.random.default_rng(seed)
    tree, centers = Neighbors(rng.normal(size=(n_points, 3))), rng.normal(size=(n_centers, 3))
    owners = rng.integers(n_centers, size=n_points).astype(np.int32)
    nearest_centers(tree, centers, owners)
    assert np.array_equal(owners, KDTree(centers).query(tree.sorted_points)[1])


@given(seed=st.integers(0, 2**32 - 1), n_points=st.integers(2, 200))
@settings(max_examples=40, deadline=None)
def test_a_line_is_cut_where_a_sorted_sum_says(seed, n_points):
    rng = np.random.default_rng(seed)
    points = rng.permutation(n_points)[:, None] * [[1.0, 0.0, 0.0]]
    weights = rng.random(n_points) + 0.1
    order = np.argsort(points[:, 0])
    reached = np.searchsorted(np.cumsum(weights[order]), weights.sum() / 2) + 1
    expected = np.empty(n_points, dtype=np.int32)
    expected[order] = np.arange(n_points) >= np.clip(reached, 1, n_points - 1)
    assert np.array_equal(bisect(points, weights, 2), expected)
