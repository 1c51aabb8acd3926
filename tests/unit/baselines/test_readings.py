"""Readings of publications: what their authors' sentences and formulas demand of simple shapes."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from lpcompare.geometry.graphs import nearest_others
from lpcompare.registry import call
from lpcompare.types import PointCloud
from lpcompare_baselines._hoods import normals_and_variation
from lpcompare_baselines.alexa_mls import contribution
from lpcompare_baselines.dey_decimation import feature_sizes
from lpcompare_baselines.han_normals import tangent_distance
from lpcompare_baselines.linsen_information import information
from lpcompare_baselines.song_feng import left_out_distance

NOTHING = np.empty((0, 0))
AWAY = np.array([3.0, 0.0, 0.0])


def sphere(n, radius=1.0):
    """Evenly spread points (Fibonacci's spiral)."""
    heights = 1 - (2 * np.arange(n) + 1) / n
    turns = np.pi * (1 + 5**0.5) * np.arange(n)
    around = np.sqrt(1 - heights**2)
    return radius * np.column_stack([around * np.cos(turns), around * np.sin(turns), heights])


def cube(n_side):
    """A grid on the surface of the unit cube, its edges included."""
    line = np.linspace(0, 1, n_side)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid[((grid == 0) | (grid == 1)).any(axis=1)]


def on_edge(points):
    return ((points == 0) | (points == 1)).sum(axis=1) >= 2


def plane(n, seed=0):
    return np.column_stack([np.random.default_rng(seed).random((n, 2)), np.zeros(n)])


def thin(name, points, m, **settings):
    return call(name, PointCloud(points), m, random_state=0, settings=settings)


def importances(measure, points, k, data):
    hoods = nearest_others(points, k)[1]
    return np.array([measure(i, hood, points, data) for i, hood in enumerate(hoods)])


def test_han_importance_is_the_squared_spacing_over_the_radius():
    means = []
    for n, radius in ((1500, 1.0), (6000, 2.0)):  # the same spacing
        points = sphere(n, radius)
        normals, _ = normals_and_variation(points, nearest_others(points, 16)[1])
        means.append(importances(tangent_distance, points, 16, normals).mean())
    assert means[0] / means[1] == pytest.approx(2.0, rel=0.1)


def test_han_deletes_the_least_important_and_keeps_edges():
    points = cube(21)
    kept = thin("han_normals", points, 1500, edge_share=1.0).indices
    assert on_edge(points)[kept].sum() == on_edge(points).sum()
    ball = sphere(2000) * [1.0, 1.0, 0.4]
    normals, _ = normals_and_variation(ball, nearest_others(ball, 16)[1])
    values = importances(tangent_distance, ball, 16, normals)
    kept = thin("han_normals", ball, 600).indices
    assert values[kept].mean() > np.delete(values, kept).mean()


def test_alexa_contribution_vanishes_on_a_quadric_and_not_beside_it():
    half = np.random.default_rng(1).normal(size=(10, 2)) * 0.2
    flat = np.vstack([np.zeros(2), half, -half, half[:, ::-1] * [1, -1], half[:, ::-1] * [-1, 1]])
    points = np.column_stack([flat, 0.7 * (flat**2).sum(axis=1)])
    hood = nearest_others(points, 40)[1][0]
    assert contribution(0, hood, points, NOTHING) < 1e-9
    points[0, 2] += 0.01
    assert contribution(0, hood, points, NOTHING) == pytest.approx(0.01, rel=0.05)


def test_alexa_removes_a_bump_last():
    points = plane(900)
    bump = int(np.argmin(np.linalg.norm(points[:, :2] - 0.5, axis=1)))
    points[bump, 2] = 0.02
    assert bump in thin("alexa_mls", points, 30).indices


def test_dey_feature_size_of_a_sphere_is_its_radius():
    small, large = sphere(1200, 0.3), sphere(1200) + AWAY
    sizes = feature_sizes(np.vstack([small, large]))
    assert np.median(sizes[:1200]) == pytest.approx(0.3, rel=0.05)
    assert np.median(sizes[1200:]) == pytest.approx(1.0, rel=0.05)


def test_dey_keeps_equally_many_points_of_a_small_and_a_large_sphere():
    points = np.vstack([sphere(1200, 0.3), sphere(1200) + AWAY])
    kept = thin("dey_decimation", points, 400).indices
    assert (kept < 1200).sum() == pytest.approx(200, abs=30)


def test_linsen_information_is_least_inside_a_plane_and_higher_at_rims_and_edges():
    line = np.linspace(0, 1, 15)
    flat = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    points = np.column_stack([flat, np.zeros(len(flat))])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    values = importances(information, points, 12, normals)
    rim = ((flat == 0) | (flat == 1)).any(axis=1)
    inside = ((flat > 0.2) & (flat < 0.8)).all(axis=1)
    assert values[inside].max() < 1e-9
    assert values[rim].min() > 0.1
    box = cube(15)
    kept = thin("linsen_information", box, 400).indices
    assert on_edge(box)[kept].mean() > on_edge(box).mean()


def test_song_feng_keeps_every_point_of_a_sharp_edge_that_fits():
    points = cube(21)
    n_edges = int(on_edge(points).sum())
    kept = thin("song_feng", points, 1600, edge_share=1.0).indices
    assert on_edge(points)[kept].sum() >= 0.95 * n_edges


def test_song_feng_thins_a_plane_evenly_because_nothing_is_important():
    points = plane(2000)
    assert importances(left_out_distance, points, 16, NOTHING).max() < 1e-12
    kept = points[thin("song_feng", points, 300).indices]
    gaps = KDTree(kept).query(kept, 2)[0][:, 1]
    assert gaps.std() / gaps.mean() < 0.6


@pytest.mark.parametrize("name", ["song_feng", "alexa_mls", "linsen_information", "dey_decimation"])
def test_removals_are_progressive(name):
    points = sphere(700) * [1.0, 0.8, 0.4]
    settings = {"edge_share": 0.0} if name == "song_feng" else {}
    few, many = (thin(name, points, m, **settings).indices for m in (100, 300))
    assert np.isin(few, many).all()
