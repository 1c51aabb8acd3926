"""Incremental clustering of Pauly, Gross and Kobbelt: a partition, its sizes, and the input's density."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lpcompare.geometry.graphs import nearest_others
from lpcompare_baselines.pauly_incremental import _grow, grow_clusters, pauly_incremental
from lpcompare_baselines.pauly_incremental_subset import pauly_incremental_subset


def sphere(n, ratio, seed=0):
    """Upper and lower half sampled in a ratio."""
    points = np.random.default_rng(seed).normal(size=(8 * n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    n_upper = n * ratio // (ratio + 1)
    upper, lower = points[points[:, 2] > 0][:n_upper], points[points[:, 2] <= 0][: n - n_upper]
    return np.concatenate([upper, lower])


def grown(points, size, max_variation=np.inf):
    return _grow(points, nearest_others(points, 10)[1], 0, float(size), max_variation)


@settings(deadline=None)
@given(st.integers(0, 1000), st.floats(1, 40))
def test_before_strays_are_dissolved_clusters_are_connected_and_not_too_large(seed, size):
    points = np.random.default_rng(seed).normal(size=(200, 3))
    labels, variations = grown(points, size)
    assert np.array_equal(np.unique(labels), np.arange(len(variations)))
    assert np.bincount(labels).max() <= np.ceil(size)
    neighbors = nearest_others(points, 10)[1]
    rows, columns = np.repeat(np.arange(200), 10), neighbors.ravel()
    inside = labels[rows] == labels[columns]
    graph = coo_array((np.ones(inside.sum()), (rows[inside], columns[inside])), shape=(200, 200))
    assert connected_components(graph, directed=False)[0] == len(variations)


def test_a_size_that_is_not_whole_is_kept_on_average():
    points = np.column_stack([np.random.default_rng(0).uniform(size=(5000, 2)), np.zeros(5000)])
    sizes = np.bincount(grown(points, 5.5)[0])
    assert set(np.unique(sizes[sizes > 4])) == {5, 6}


def test_clusters_stop_growing_where_they_bend():
    x, y = np.random.default_rng(0).uniform(size=(2, 6000))
    points = np.column_stack([2 * x - 1, y, np.where(x > 0.5, 0.05 * np.sin(40 * x), 0.0)])
    labels, variations = grown(points, 40, 0.003)
    sizes = np.bincount(labels)
    middles = np.bincount(labels, weights=points[:, 0]) / sizes
    bent, flat = middles > 0.2, middles < -0.2
    assert np.median(sizes[bent]) < 0.5 * np.median(sizes[flat])
    assert (variations[flat] < 0.003).all()


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(1, 60), st.data())
def test_the_count_is_exact_and_every_point_is_in_one_cluster(seed, n, data):
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 3, size=(n, 3)).astype(float)
    target = data.draw(st.integers(1, n))
    labels = grow_clusters(points, target, np.inf, rng)
    assert np.array_equal(np.unique(labels), np.arange(target))
    assert len(pauly_incremental_subset(points, target, rng=rng).indices) == target


def test_the_weighted_mean_of_the_result_is_the_mean_of_the_input():
    points = sphere(3000, 4) + 7.0
    labels = grow_clusters(points, 300, np.inf, np.random.default_rng(2))
    means = pauly_incremental(points, 300, rng=np.random.default_rng(2)).points
    assert np.bincount(labels) @ means == pytest.approx(points.sum(axis=0))


@pytest.mark.parametrize("target", [100, 400])
def test_on_a_plane_clusters_lie_between_half_and_twice_their_mean_size(target):
    points = np.column_stack([np.random.default_rng(0).uniform(size=(4000, 2)), np.zeros(4000)])
    sizes = np.bincount(grow_clusters(points, target, np.inf, np.random.default_rng(0)))
    assert (sizes >= 0.5 * 4000 / target).mean() > 0.98
    assert (sizes <= 2 * 4000 / target).mean() > 0.98


@pytest.mark.parametrize("seed", range(3))
def test_the_result_is_as_dense_as_the_input(seed):
    kept = pauly_incremental(sphere(10000, 4, seed), 1000, rng=np.random.default_rng(seed)).points
    upper, lower = (kept[:, 2] > 0).sum(), (kept[:, 2] <= 0).sum()
    assert upper / lower == pytest.approx(4, rel=0.1)
