"""Metrics on clouds whose answer is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare.metrics.comparison import Comparison
from lpcompare.metrics.mls_distance import mls_distances
from lpcompare.registry import METRICS

LINE = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [10, 0, 0]])
KEPT = LINE[[0, 4]]
"""Distances of the five to the two kept: 0, 1, 2, 3, 0; the diagonal is 10."""


def value(name, original, simplified):
    return METRICS.get(name)(Comparison(np.asarray(original, float), np.asarray(simplified, float)))


def plane(n=20, spacing=1.0):
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    return spacing * np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])


def test_hausdorff_each_way():
    found = value("hausdorff", LINE, [[0, 0, 0], [10, 4, 0]])
    assert found == {"hausdorff_pct": pytest.approx(40), "hausdorff_backward_pct": pytest.approx(40)}
    found = value("hausdorff", LINE, KEPT)
    assert found == {"hausdorff_pct": pytest.approx(30), "hausdorff_backward_pct": 0}
    assert value("hausdorff", KEPT, LINE)["hausdorff_pct"] == pytest.approx(30)


def test_mean_distance_each_way():
    found = value("mean_distance", LINE, KEPT)
    assert found["mean_distance_backward_pct"] == 0
    assert found["mean_distance_pct"] == pytest.approx(12)
    found = value("mean_distance", KEPT, LINE)
    assert found["mean_distance_backward_pct"] == pytest.approx(12)
    assert found["mean_distance_pct"] == pytest.approx(12)


def test_chamfer_adds_both_ways():
    found = value("chamfer", LINE, [[0, 0, 0], [10, 4, 0]])
    assert found["chamfer_pct"] == pytest.approx(100 * ((0 + 1 + 2 + 3 + 4) / 5 + (0 + 4) / 2) / 10)
    assert found["chamfer_squared"] == pytest.approx((0 + 1 + 4 + 9 + 16) / 5 + 16 / 2)


def test_eq_27_in_percent_is_the_mean_plane_distance_over_the_diagonal():
    original, kept = plane(30) + np.array([0.0, 0.0, 2.0]), plane(30)
    comparison = Comparison(original, kept)
    assert comparison.plane_error_percent() == pytest.approx(100 * 2 / (29 * math.sqrt(2)))
    assert comparison.plane_error_percent() == comparison.percent(comparison.plane_errors(8).mean())
    found = value("plane_error", original, kept)
    assert found["plane_error_pct"] == comparison.plane_error_percent(8)
    assert found["plane_error"] == pytest.approx(2)


def test_d1_takes_the_larger_way_and_the_squared_diagonal_as_peak():
    found = value("mpeg_d1", LINE, KEPT)
    assert found["d1_mse"] == pytest.approx(14 / 5)
    assert found["d1_psnr_db"] == pytest.approx(10 * math.log10(100 / 2.8))
    assert value("mpeg_d1", LINE, LINE)["d1_psnr_db"] == math.inf
    assert math.isnan(value("mpeg_d1", np.zeros((3, 3)), np.zeros((1, 3)))["d1_psnr_db"])


def test_d2_counts_what_lies_along_the_normal_alone():
    flat = plane()
    assert value("mpeg_d2", flat, flat[::3])["d2_mse"] == pytest.approx(0, abs=1e-20)
    lifted = value("mpeg_d2", flat, flat[::3] + np.array([0, 0, 0.5]))
    assert lifted["d2_mse"] == pytest.approx(0.25)
    assert lifted["d2_psnr_db"] == pytest.approx(10 * math.log10(2 * 19**2 / 0.25))


def test_normals_of_a_tilted_copy_deviate_by_the_tilt():
    flat, angle = plane(), np.radians(25)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    assert value("normal_deviation", flat, flat @ turn.T)["normal_deviation_deg"] == pytest.approx(25)
    assert value("normal_deviation", flat, flat)["normal_deviation_deg"] == pytest.approx(0, abs=1e-6)


def test_spacing_varies_on_no_lattice_and_by_half_between_one_and_three():
    assert value("spacing_variation", plane(), plane())["spacing_variation"] == pytest.approx(0, abs=1e-12)
    kept = np.array([[0.0, 0, 0], [1, 0, 0], [100, 0, 0], [103, 0, 0]])
    assert value("spacing_variation", kept, kept)["spacing_variation"] == pytest.approx(0.5)


def test_an_equal_cloud_keeps_every_density_and_an_emptied_cluster_loses_its_own():
    blobs = np.random.default_rng(0).normal(size=(4000, 3))
    assert value("density_objective", blobs, blobs)["density_objective_max_pct"] == pytest.approx(0, abs=1e-9)
    half = value("density_objective", blobs, blobs[blobs[:, 0] > 1])
    assert half["density_objective_max_pct"] == pytest.approx(100)
    rim = value("density_objective", blobs, blobs[::2])
    assert rim["density_objective_pct"] < 15


def ball(n_points):
    """Random points on the unit sphere."""
    points = np.random.default_rng(0).normal(size=(n_points, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


SURFACES = pytest.mark.parametrize("name", ["surface_distance", "pivoted_distance"])


@SURFACES
def test_the_surface_of_a_thinned_plane_is_the_plane(name):
    found = value(name, plane(40), plane(20, spacing=2.0))
    inside = value(name, plane(39), plane(20, spacing=2.0))
    assert inside[f"{name}_max_pct"] == pytest.approx(0, abs=1e-6)
    assert found[f"{name}_max_pct"] == pytest.approx(100 * math.sqrt(2) / (39 * math.sqrt(2)))


@SURFACES
def test_the_surface_of_a_sphere_lies_a_sagitta_inside(name):
    sphere = ball(6000)
    found = value(name, sphere, sphere[:1500])
    assert 0.01 < found[f"{name}_pct"] < 0.2
    assert found[f"{name}_max_pct"] < value("hausdorff", sphere, sphere[:1500])["hausdorff_pct"]


@SURFACES
def test_the_surface_does_not_depend_on_the_order_of_the_points(name):
    sphere = ball(3000)
    shuffled = np.random.default_rng(1).permutation(sphere[:700])
    assert value(name, sphere, sphere[:700]) == value(name, sphere, shuffled)


@SURFACES
@pytest.mark.parametrize(
    "kept", [LINE[:1], LINE[:2], KEPT, np.zeros((4, 3))], ids=["one", "two", "ends", "same"]
)
def test_points_without_a_triangle_stand_for_the_surface(name, kept):
    found = value(name, LINE, kept)
    assert found[f"{name}_max_pct"] == value("hausdorff", LINE, kept)["hausdorff_pct"]


def test_the_surface_follows_the_spacing_where_one_ball_does_not():
    """Of two planes, one twenty times as coarse, balls of one size represent the finer one only."""
    above = np.array([0.0, 0.0, 400.0])
    original = np.concatenate([plane(60), plane(60, spacing=20.0) + above])
    kept = np.concatenate([plane(30, spacing=2.0), plane(30, spacing=40.0) + above])
    rim = 100 * 20 * math.sqrt(2) / np.linalg.norm(np.ptp(original, axis=0))
    assert value("surface_distance", original, kept)["surface_distance_max_pct"] == pytest.approx(rim)
    assert value("surface_distance", original, kept)["surface_distance_p95_pct"] < 0.8 * rim
    mean = {
        name: value(name, original, kept)[f"{name}_pct"] for name in ("surface_distance", "pivoted_distance")
    }
    assert mean["surface_distance"] < 0.75 * mean["pivoted_distance"]


@pytest.mark.parametrize("seed", range(3))
def test_a_hundredth_of_the_points_exchanged_changes_the_surface_by_less_than_three_hundredths(seed):
    """On an open scene whose density falls with distance, as a scanner on the ground sees it."""
    rng = np.random.default_rng(seed)
    radius, angle = 2 * np.exp(rng.uniform(0, 3, 12000)), rng.uniform(0, 2 * np.pi, 12000)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    scene = np.column_stack([x, y, np.sin(x / 3) * np.cos(y / 4)])
    rows = rng.permutation(len(scene))
    kept, other = rows[:1200], rows[12:1212]
    before, after = (
        value("surface_distance", scene, scene[r])["surface_distance_pct"] for r in (kept, other)
    )
    assert after == pytest.approx(before, rel=0.03)


@given(st.integers(0, 1000), st.integers(2, 60), st.integers(1, 60))
def test_distances_obey_their_order(seed, n, m):
    rng = np.random.default_rng(seed)
    original, kept = rng.normal(size=(n, 3)), rng.normal(size=(m, 3))
    farthest, mean = value("hausdorff", original, kept), value("mean_distance", original, kept)
    assert mean["mean_distance_pct"] <= farthest["hausdorff_pct"] + 1e-9
    assert value("chamfer", original, kept)["chamfer_pct"] <= 2 * farthest["hausdorff_pct"] + 1e-9
    swapped = METRICS.get("mpeg_d1")(Comparison(kept, original))["d1_mse"]
    assert value("mpeg_d1", original, kept)["d1_mse"] == pytest.approx(swapped)
    d2 = value("mpeg_d2", original, kept)["d2_mse"]
    assert d2 <= value("mpeg_d1", original, kept)["d1_mse"] * (1 + 1e-9)


@given(st.integers(0, 1000), st.integers(5, 40))
def test_a_larger_subset_covers_no_less(seed, n):
    rng = np.random.default_rng(seed)
    original = rng.normal(size=(n, 3))
    few, more = original[: n // 3 + 1], original[: n // 2 + 1]
    for metric in ("mean_distance", "hausdorff"):
        larger, smaller = (value(metric, original, kept)[f"{metric}_pct"] for kept in (more, few))
        assert larger <= smaller + 1e-12


def test_the_mls_distance_to_a_plane_is_that_along_its_normal():
    lifted = plane(40)[::7] + np.array([0.0, 0.0, 0.25])
    found = value("mls_distance", lifted, plane(40))
    assert found["mls_distance_pct"] == pytest.approx(100 * 0.25 / np.linalg.norm(np.ptp(lifted, axis=0)))
    assert found["mls_distance_max_pct"] == pytest.approx(found["mls_distance_pct"])
    assert value("mls_distance", plane(), plane())["mls_distance_max_pct"] == pytest.approx(0, abs=1e-12)


def test_the_mls_distance_of_a_pole_to_a_ring_of_its_sphere_is_the_sagitta():
    """All twelve neighbours weigh alike, so that the plane is that of their circle."""
    angles, polar = np.arange(12) * np.pi / 6, 0.1
    ring = np.column_stack(
        [np.sin(polar) * np.cos(angles), np.sin(polar) * np.sin(angles), np.full(12, np.cos(polar))]
    )
    comparison = Comparison(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), ring)
    assert mls_distances(comparison)[0] == pytest.approx(1 - np.cos(polar))


def test_the_mls_distance_falls_with_the_square_of_the_spacing_on_a_sphere():
    def mean(n):
        turns = np.arange(n) * np.pi * (3 - math.sqrt(5))
        height = 1 - (2 * np.arange(n) + 1) / n
        radius = np.sqrt(1 - height**2)
        spiral = np.column_stack([radius * np.cos(turns), radius * np.sin(turns), height])
        queries = np.random.default_rng(0).normal(size=(2000, 3))
        queries /= np.linalg.norm(queries, axis=1, keepdims=True)
        return mls_distances(Comparison(queries, spiral)).mean()

    assert mean(1000) / mean(4000) == pytest.approx(4, rel=0.02)


def test_the_mls_distance_above_a_quadric_is_its_weighted_mean_height():
    """By the definition, point by point: the bowl is symmetric, so that the plane is level."""
    bowl = plane(9) - 4.0
    bowl[:, 2] = 0.05 * (bowl[:, 0] ** 2 + bowl[:, 1] ** 2)
    comparison = Comparison(np.array([[0.0, 0.0, 0.0], [8.0, 8.0, 8.0]]), bowl)
    near = sorted(bowl.tolist(), key=lambda p: p[0] ** 2 + p[1] ** 2 + p[2] ** 2)[:9]
    width = math.dist(near[-1], [0.0, 0.0, 0.0]) / 3
    foot = 0.0
    for _ in range(60):
        weights = [math.exp(-(math.dist(p, [0.0, 0.0, foot]) ** 2) / width**2) for p in near]
        foot = sum(w * p[2] for w, p in zip(weights, near, strict=True)) / sum(weights)
    assert foot > 0
    assert mls_distances(comparison, 9)[0] == pytest.approx(foot, rel=1e-9)
