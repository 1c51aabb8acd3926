"""Point-pair contraction of Pauly, Gross and Kobbelt: its quadrics, the order of its costs, what it conserves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lpcompare as lp
from lpcompare_baselines._contraction import ROUNDING, least, shifted, tangent_quadrics
from lpcompare_baselines.pauly_iterative import contract_pairs, pauly_iterative
from lpcompare_baselines.pauly_iterative_subset import pauly_iterative_subset

RNG = np.random.default_rng(0)
UPPER = np.triu_indices(3)


def value(quadric, x):
    """x'Ax + 2 b'x + c, written out."""
    matrix = np.zeros((3, 3))
    matrix[UPPER] = quadric[:6]
    matrix = matrix + np.triu(matrix, 1).T
    return x @ matrix @ x + 2 * quadric[6:9] @ x + quadric[9]


def some_quadric(rng, n_planes=5):
    """Sum of squared distances to random planes, and those planes."""
    normals = rng.normal(size=(n_planes, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = rng.normal(size=n_planes)
    matrix = normals.T @ normals
    return np.concatenate([matrix[UPPER], offsets @ normals, [offsets @ offsets]]), normals, offsets


@settings(deadline=None)
@given(st.integers(0, 1000))
def test_a_tangent_quadric_is_the_squared_distance_to_the_planes_of_the_edges(seed):
    rng = np.random.default_rng(seed)
    points, x = rng.normal(size=(7, 3)), rng.normal(size=3)
    normals = rng.normal(size=(7, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    expected = 0.0
    for other in points[1:]:
        edge = points[0] - other
        plane = np.cross(edge, np.cross(edge, normals[0]))  # spanned by the edge and edge x normal
        expected += (plane @ x / np.linalg.norm(plane)) ** 2
    found = tangent_quadrics(points, normals, np.array([[1, 2, 3, 4, 5, 6]] + [[0] * 6] * 6))[0]
    assert value(found, x) == pytest.approx(expected)


@settings(deadline=None)
@given(st.integers(0, 1000))
def test_a_shifted_quadric_has_the_same_values_at_the_same_places(seed):
    rng = np.random.default_rng(seed)
    quadric, _, _ = some_quadric(rng)
    offset, x = rng.normal(size=(2, 3))
    assert value(shifted(quadric, offset), x - offset) == pytest.approx(value(quadric, x))


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(1, 6))
def test_the_least_value_is_that_of_the_least_squares_problem(seed, n_planes):
    quadric, normals, offsets = some_quadric(np.random.default_rng(seed), n_planes)
    place = np.empty(3)
    found = least(quadric, ROUNDING, place)
    best = np.linalg.lstsq(normals, -offsets, rcond=1e-9)[0]
    assert found == pytest.approx(np.square(normals @ best + offsets).sum(), abs=1e-7)
    assert value(quadric, place) == pytest.approx(found, abs=1e-6)


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(20, 200))
def test_costs_never_decrease(seed, n):
    points = np.random.default_rng(seed).normal(size=(n, 3)) * [2.0, 1.0, 0.1]
    costs = contract_pairs(points, n // 4, 8, subset=False).costs
    assert (np.diff(costs) >= -1e-9 * costs[1:]).all()


@pytest.mark.shared
def test_costs_never_decrease_over_thirty_thousand_contractions_of_a_real_scan(shared_models):
    points = lp.read(shared_models / "upstream" / "stanford-bunny.obj").points
    result = contract_pairs(points, len(points) - 30000, 8, subset=False)
    assert len(result.costs) == 30000
    assert (np.diff(result.costs) >= -1e-9 * result.costs[1:]).all()
    assert result.costs[-1] > 100 * result.costs[0]


@pytest.mark.parametrize("subset", [False, True])
def test_the_sum_of_all_quadrics_is_conserved(subset):
    points = np.random.default_rng(3).normal(size=(800, 3)) * [1.0, 1.0, 0.2]
    whole = contract_pairs(points, 800, 8, subset=subset)
    thinned = contract_pairs(points, 60, 8, subset=subset)
    for x in np.random.default_rng(4).normal(size=(5, 3)):
        before, after = (
            sum(value(r.quadrics[row], x - r.points[row]) for row in np.flatnonzero(r.alive))
            for r in (whole, thinned)
        )
        assert after == pytest.approx(before, rel=1e-10)


def test_on_a_plane_nothing_costs_and_points_stay_on_it():
    points = np.column_stack([np.random.default_rng(0).uniform(size=(2000, 2)), np.zeros(2000)])
    turned = points @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    result = contract_pairs(turned, 200, 8, subset=False)
    assert result.costs.max() < 1e-12
    kept = pauly_iterative(turned, 200, rng=RNG).points
    flat = np.linalg.svd(kept - kept.mean(axis=0), compute_uv=False)
    assert flat[2] < 1e-9 * flat[0]


def test_the_faces_of_a_cube_are_thinned_before_its_edges():
    t = np.linspace(-1, 1, 21)
    grid = np.stack(np.meshgrid(t, t, t), axis=-1).reshape(-1, 3)
    cube = grid[np.abs(grid).max(axis=1) == 1]
    kept = pauly_iterative(cube, len(cube) // 5, rng=RNG).points
    on_edge = lambda p: (np.sort(np.abs(p), axis=1)[:, 1] > 0.9).mean()  # noqa: E731
    assert on_edge(kept) > 1.5 * on_edge(cube)
    assert np.abs(np.abs(kept).max(axis=1) - 1).mean() < 0.01


def test_the_subset_keeps_points_where_they_are():
    points = np.random.default_rng(5).normal(size=(500, 3))
    kept = pauly_iterative_subset(points, 50, rng=RNG)
    assert np.array_equal(points[kept.indices], kept.points)
    assert len(kept.indices) == 50


@pytest.mark.parametrize("target", [1, 2, 5])
def test_clouds_that_lie_far_apart_are_contracted_to_any_count(target):
    blobs = [np.random.default_rng(i).normal(size=(40, 3)) + 1000 * i for i in range(4)]
    assert len(pauly_iterative(np.concatenate(blobs), target, rng=RNG)) == target
    assert len(pauly_iterative(np.ones((12, 3)), target, rng=RNG)) == target
