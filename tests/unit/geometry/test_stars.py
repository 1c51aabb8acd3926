"""Stars against scipy's Delaunay triangulation, and distances to triangles against dense samples of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay, cKDTree

from lpcompare.geometry.stars import make_stars

UP = np.array([0.0, 0.0, 1.0])


@settings(deadline=None)
@given(st.integers(0, 10_000), st.integers(8, 60))
def test_in_a_plane_a_star_has_the_neighbours_of_the_delaunay_triangulation(seed, n_points):
    points = np.zeros((n_points, 3))
    points[:, :2] = np.random.default_rng(seed).normal(size=(n_points, 2))
    everyone = np.tile(np.arange(n_points), (n_points, 1))
    stars = make_stars(points, np.tile(UP, (n_points, 1)), everyone)
    ends, neighbours = Delaunay(points[:, :2]).vertex_neighbor_vertices
    for i in range(n_points):
        expected = set(neighbours[ends[i] : ends[i + 1]].tolist())
        if len(expected) <= stars.corners.shape[1]:
            assert set(stars.corners[i, : stars.counts[i]].tolist()) == expected


def test_a_star_is_open_at_the_rim_only():
    rng = np.random.default_rng(0)
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    inside = np.column_stack([rng.uniform(-0.6, 0.6, (200, 2)), np.zeros(200)])
    points = np.concatenate([rim, inside])
    stars = make_stars(points, np.tile(UP, (260, 1)), np.tile(np.arange(260), (260, 1)))
    assert not stars.closed[:60].any()
    assert stars.closed[60:].all()


def test_the_opposite_sheet_does_not_enter_a_star():
    rng = np.random.default_rng(0)
    sheet = np.column_stack([rng.uniform(0, 10, (400, 2)), np.zeros(400)])
    points = np.concatenate([sheet, sheet + np.array([0.05, 0.05, 0.4])])
    nearest = cKDTree(points).query(points, 24)[1]
    stars = make_stars(points, np.tile(UP, (800, 1)), nearest)
    inner = np.flatnonzero(((sheet > 1) & (sheet < 9))[:, :2].all(axis=1))
    across = [np.mean(stars.corners[i, : stars.counts[i]] >= 400) for i in inner]
    assert np.mean(across) < 0.5


@settings(deadline=None)
@given(st.integers(0, 10_000))
def test_the_distance_to_a_triangle_is_that_to_a_dense_sample_of_it(seed):
    rng = np.random.default_rng(seed)
    corners, query = rng.normal(size=(3, 3)), 2 * rng.normal(size=(1, 3))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normals = np.tile(normal / np.linalg.norm(normal), (3, 1))
    stars = make_stars(corners, normals, np.tile(np.arange(3), (3, 1)))
    u, v = np.meshgrid(np.linspace(0, 1, 201), np.linspace(0, 1, 201))
    inside = u + v <= 1
    sample = (
        corners[0] + u[inside, None] * (corners[1] - corners[0]) + v[inside, None] * (corners[2] - corners[0])
    )
    expected = np.linalg.norm(sample - query, axis=1).min()
    found = stars.distances(query, np.array([[0, 1, 2]]))[0]
    assert found <= expected + 1e-12
    assert found == pytest.approx(expected, abs=0.02 * np.linalg.norm(np.ptp(corners, axis=0)))


def test_points_at_one_place_have_no_triangle():
    stars = make_stars(np.zeros((4, 3)), np.tile(UP, (4, 1)), np.tile(np.arange(4), (4, 1)))
    assert not stars.counts.any()
    assert stars.distances(np.array([[3.0, 4.0, 0.0]]), np.array([[0, 1]]))[0] == 5.0
