"""The k-d tree against the full distance matrix."""

import numpy as np
import pytest

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.threads import thread_count


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
