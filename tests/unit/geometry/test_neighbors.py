"""The k-d tree against the full distance matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from lpcompare.geometry.kernels import LEAF, gather
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.threads import thread_count


@given(
    seed=st.integers(0, 2**32 - 1),
    n_points=st.integers(1, 300),
    k=st.integers(1, 20),
    copies=st.integers(1, 30),
)
@settings(max_examples=60, deadline=None)
def test_neighbours_equal_those_of_scipy(seed, n_points, k, copies):
    rng = np.random.default_rng(seed)
    points = np.repeat(rng.normal(size=(n_points, 3)), copies, axis=0)
    queries = np.concatenate([points[:50], rng.normal(size=(50, 3))])
    distances, indices = Neighbors(points).query(queries, k)
    expected, rows = KDTree(points).query(queries, [*range(1, min(k, len(points)) + 1)])
    assert np.array_equal(distances, expected)
    assert copies > 1 or np.array_equal(indices, rows)


@given(seed=st.integers(0, 2**32 - 1), n_points=st.integers(0, 300))
@settings(max_examples=60, deadline=None)
def test_the_order_holds_every_row_once_and_leaves_are_few_points(seed, n_points):
    points = np.random.default_rng(seed).normal(size=(n_points, 3))
    tree = Neighbors(points)
    assert np.array_equal(np.sort(tree.order), np.arange(n_points))
    assert np.array_equal(tree.sorted_points, points[tree.order])
    assert np.diff(tree.leaves).max() <= LEAF
    assert tree.leaves[-1] == n_points


@given(seed=st.integers(0, 2**32 - 1), n_points=st.integers(1, 300), radius=st.floats(0.01, 3))
@settings(max_examples=60, deadline=None)
def test_a_box_gathers_what_is_near_it(seed, n_points, radius):
    rng = np.random.default_rng(seed)
    tree = Neighbors(rng.normal(size=(n_points, 3)))
    low, high = np.sort(rng.normal(size=(2, 3)), axis=0)
    found = np.empty(n_points, dtype=np.int32)
    count = gather(low, high, radius**2, *tree.arrays, found)
    offsets = np.maximum(0, np.maximum(low - tree.sorted_points, tree.sorted_points - high))
    near = np.flatnonzero(np.square(offsets).sum(axis=1) < radius**2)
    assert np.array_equal(np.sort(found[:count]), near)


def test_a_hundred_thousand_points_at_one_place_take_no_longer_than_others():
    distances, _ = Neighbors(np.zeros((100_000, 3))).query(np.zeros((2000, 3)), 5)
    assert (distances == 0).all()


@pytest.mark.parametrize("threads", ["1", "2", "8"])
def test_threads_change_nothing(monkeypatch, threads):
    points = np.random.default_rng(0).normal(size=(20_000, 3))
    monkeypatch.setenv("LPCOMPARE_THREADS", threads)
    tree = Neighbors(points)
    monkeypatch.setenv("LPCOMPARE_THREADS", "3")
    assert np.array_equal(tree.order, Neighbors(points).order)


def test_neighbours_equal_the_sorted_distance_matrix():
    points = np.random.default_rng(0).normal(size=(60, 3))
    distances, indices = Neighbors(points[:40]).query(points[40:], 5)
    full = np.linalg.norm(points[40:, None] - points[None, :40], axis=2)
    assert distances == pytest.approx(np.sort(full, axis=1)[:, :5])
    assert np.array_equal(indices, np.argsort(full, axis=1)[:, :5])


@pytest.mark.parametrize("k", [1, 3, 9])
def test_more_neighbours_than_points_are_cut_to_the_cloud(k):
    distances, indices = Neighbors(np.eye(3)).query(np.zeros((2, 3)), k)
    assert distances.shape == indices.shape == (2, min(k, 3))


def test_box_of_a_unit_cube_far_away():
    corners = np.array([[5e5, 4e6, 10.0], [5e5 + 1, 4e6 + 1, 11.0]])
    assert bounding_box_diagonal(corners) == pytest.approx(np.sqrt(3))
    assert bounding_box_center(corners) == pytest.approx([5e5 + 0.5, 4e6 + 0.5, 10.5])


def test_threads_follow_the_environment(monkeypatch):
    monkeypatch.setenv("LPCOMPARE_THREADS", "3")
    assert thread_count() == 3
    monkeypatch.setenv("LPCOMPARE_THREADS", "many")
    assert thread_count() >= 1
