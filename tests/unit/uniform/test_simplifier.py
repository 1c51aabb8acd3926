"""lp_uniform and lp_placed from points to points."""

import numpy as np
import pytest

import lpcompare
from lpcompare.errors import InputError
from lpcompare.estimators import UniformSimplifier
from lpcompare.metrics.comparison import Comparison
from lpcompare.registry import METHODS


def simplify_uniformly(points, **settings):
    return UniformSimplifier(**settings).fit(points).simplification_


def torus(n_points=4000, seed=0):
    u, v = np.random.default_rng(seed).random((2, n_points)) * 2 * np.pi
    ring = 1 + 0.4 * np.cos(v)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)])


def error(points, reduced):
    return Comparison(points, reduced).plane_errors(8).mean()


def reach(points, reduced):
    return Comparison(points, reduced).forward_distances.max()


def test_better_than_random_and_without_its_holes():
    points = torus()
    result = simplify_uniformly(points, target_count=400)
    drawn = points[np.random.default_rng(0).choice(len(points), 400, replace=False)]
    assert error(points, result.points) < 0.95 * error(points, drawn)
    assert reach(points, result.points) < 0.6 * reach(points, drawn)


def test_density_of_every_cluster_is_kept():
    result = simplify_uniformly(torus(), target_count=1000)
    assert result.info["largest_residual"] <= 0.0501
    assert result.info["n_certified"] == result.info["n_clusters"] == 20
    assert set(result.timings) == {"clustering", "curvature", "cells", "swaps", "selection"}


def test_placed_points_come_from_the_same_rows_and_halve_the_offset_of_a_sphere():
    points = np.random.default_rng(0).normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    kept = simplify_uniformly(points, target_count=300)
    placed = simplify_uniformly(points, target_count=300, placed=True)
    assert placed.indices is None
    assert np.array_equal(placed.info["source"], kept.indices)
    assert error(points, placed.points) < 0.8 * error(points, kept.points)


def test_placed_points_stay_on_the_surface_at_sharp_edges():
    faces = np.random.default_rng(0).random((6000, 3))
    faces[np.arange(6000), np.arange(6000) % 3] = np.arange(6000) // 3 % 2
    placed = simplify_uniformly(faces, target_count=500, placed=True)
    outside = np.maximum(np.abs(placed.points - 0.5).max(axis=1) - 0.5, 0)
    inside = np.maximum(0.5 - np.abs(placed.points - 0.5).max(axis=1), 0)
    spacing = Comparison(faces, placed.points).spacings.mean()
    assert max(outside.max(), inside.max()) < 0.25 * spacing


@pytest.mark.parametrize("method", ["lp_uniform", "lp_placed"])
def test_simplify_reaches_both_methods(method):
    points = torus(600)
    direct = METHODS.get(method)(points, 150, rng=np.random.default_rng(0))
    through = lpcompare.simplify(points, target_count=150, method=method)
    assert np.array_equal(direct.points, through.points)


def test_same_points_on_one_thread_or_two(monkeypatch):
    points = torus(1500)
    monkeypatch.setenv("LPCOMPARE_THREADS", "1")
    alone = simplify_uniformly(points, target_count=200).indices
    monkeypatch.setenv("LPCOMPARE_THREADS", "2")
    assert np.array_equal(alone, simplify_uniformly(points, target_count=200).indices)


@pytest.mark.parametrize("scale", [2.0**-30, 2.0**40])
def test_the_unit_of_the_model_does_not_matter(scale):
    points = torus(1500)
    unit = simplify_uniformly(points, target_count=200)
    scaled = simplify_uniformly(points * scale, target_count=200)
    assert np.array_equal(unit.indices, scaled.indices)
    assert scaled.info["certificates"][0].density * scale == pytest.approx(
        unit.info["certificates"][0].density
    )


@pytest.mark.parametrize(
    "points",
    [
        np.ones((40, 3)),
        np.repeat(torus(60), 4, axis=0),
        np.linspace(0, 1, 90)[:, None] * [[1.0, 2.0, 3.0]],
        np.column_stack([torus(200)[:, :2], np.zeros(200)]),
        np.add(torus(300), [5e5, 4e6, 100.0]),
        torus(3),
    ],
    ids=["coinciding", "duplicates", "line", "plane", "utm", "three"],
)
@pytest.mark.parametrize("placed", [False, True])
def test_degenerate_clouds_have_the_exact_count(points, placed):
    for target in sorted({1, 2, len(points) // 3, len(points) - 1, len(points)} - {0}):
        result = simplify_uniformly(points, target_count=target, placed=placed)
        assert len(result) == target
        assert np.isfinite(result.points).all()


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"n_clusters": 0}, "n_clusters is 0"),
        ({"n_clusters": "many"}, "n_clusters is 'many'"),
        ({"n_rounds": -1}, "n_rounds is -1"),
        ({"density_tolerance": float("nan")}, "density_tolerance is nan"),
        ({"gap": -1.0}, "gap is -1"),
    ],
)
def test_settings_out_of_range_are_said(settings, words):
    with pytest.raises(InputError, match=words):
        simplify_uniformly(torus(50), target_count=5, **settings)
