"""Intrinsic farthest points: the greedy rule, prefixes, isometry, parts, features."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from lpcompare.registry import METHODS
from lpcompare_baselines._geodesic import geodesic_farthest_points, surface_graph

NAMES = ["moenning_geodesic", "moenning_features"]


def sheet(n_long, n_wide, seed=0):
    """A flat sheet of spacing 1, jittered: (n, 2)."""
    grid = np.stack(np.meshgrid(np.arange(n_long), np.arange(n_wide), indexing="ij"), axis=-1).reshape(-1, 2)
    return grid + np.random.default_rng(seed).uniform(-0.3, 0.3, grid.shape)


def paths(surface, sources):
    n = len(surface.starts) - 1
    graph = csr_array((surface.lengths, surface.neighbors, surface.starts), (n, n))
    return dijkstra(graph, indices=sources)


@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_no_point_is_farther_from_the_chosen_than_two_chosen_are_from_each_other(weight):
    flat = sheet(30, 20)
    points = np.column_stack([flat, np.sin(flat[:, 0] / 3)])
    surface = surface_graph(points, 8, weight)
    order, left = geodesic_farthest_points(surface, 60)
    between = paths(surface, order)
    assert np.allclose(between.min(axis=0), left)
    among = between[:, order] + np.diag(np.full(60, np.inf))
    assert left.max() <= among.min() * (1 + 1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_every_beginning_of_the_order_is_the_thinning_of_that_size(name):
    points = np.random.default_rng(2).normal(size=(800, 3))
    long, short = (METHODS.get(name)(points, m, rng=np.random.default_rng(0)) for m in (300, 40))
    assert sorted(long.info["order"]) == list(range(300))
    assert np.array_equal(long.indices[long.info["order"] < 40], short.indices)


def test_rolling_the_sheet_up_changes_little():
    flat = sheet(80, 20)
    angle = flat[:, 0] / 60
    rolled = np.column_stack([60 * np.sin(angle), flat[:, 1], 60 * np.cos(angle)])
    kept = [
        set(geodesic_farthest_points(surface_graph(points, 10), 60)[0].tolist())
        for points in (np.column_stack([flat, np.zeros(len(flat))]), rolled)
    ]
    assert len(kept[0] & kept[1]) >= 57


def test_each_part_has_its_sample_and_small_parts_are_tied():
    rng = np.random.default_rng(3)
    parts = [rng.random((300, 3)), rng.random((200, 3)) + 50, rng.random((5, 3)) - [60, 0, 0]]
    surface = surface_graph(np.vstack(parts), 8)
    assert len(surface.firsts) == 2
    order, left = geodesic_farthest_points(surface, 2)
    assert order[0] >= 500
    assert 300 <= order[1] < 500
    assert np.isfinite(left).all()


def test_features_get_more_points():
    """A plane with a ridge: the share of points near it grows with the weight."""
    flat = sheet(60, 60)
    points = np.column_stack([flat, np.abs(flat[:, 0] - 30)])
    on_ridge = np.abs(flat[:, 0] - 30) < 4
    shares = []
    for weight in (0.0, 1.0, 4.0):
        order, _ = geodesic_farthest_points(surface_graph(points, 10, weight), 300)
        shares.append(on_ridge[order].mean())
    assert shares[0] * 1.3 < shares[1] < shares[2]
