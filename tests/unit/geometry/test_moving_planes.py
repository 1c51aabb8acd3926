"""Surface variation and moving planes, against scikit-free definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare.geometry.moving_planes import moving_planes, surface_variation


@given(st.integers(0, 1000), st.integers(1, 12))
def test_variation_is_the_share_of_the_least_variance(seed, k):
    hoods = np.random.default_rng(seed).normal(size=(4, k, 3)) * [1.0, 2.0, 0.3]
    for found, hood in zip(surface_variation(hoods), hoods, strict=True):
        values = np.linalg.svd(hood - hood.mean(axis=0), compute_uv=False) ** 2
        least = values[2] if k >= 3 else 0.0
        assert 0 <= found <= 1 / 3 + 1e-12
        assert found == pytest.approx(least / values.sum() if k > 1 else 0.0, abs=1e-12)


def test_variation_of_what_is_flat_straight_or_one_place_is_zero():
    t = np.linspace(0, 1, 8)
    line, place = np.column_stack([t, 2 * t, -t]), np.ones((8, 3))
    flat = np.column_stack([t, t**2, np.zeros(8)])
    assert surface_variation(np.stack([line, place, flat])) == pytest.approx(0, abs=1e-15)


def test_a_moving_plane_is_a_fixed_point_of_its_own_weights():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(12, 3)) * [1.0, 1.0, 0.1]
    query = np.array([[0.1, 0.0, 0.5]])
    order = np.argsort(np.linalg.norm(points - query, axis=1))[None]
    feet, normals, widths = moving_planes(query, points, order, n_rounds=60)
    assert widths[0] == pytest.approx(np.linalg.norm(points - query, axis=1).max() / 3)
    weights = np.exp(-np.square(points - feet[0]).sum(axis=1) / widths[0] ** 2)
    mean = weights @ points / weights.sum()
    covariance = (points - mean).T * weights @ (points - mean)
    normal = np.linalg.eigh(covariance)[1][:, 0]
    assert abs(normal @ normals[0]) == pytest.approx(1)
    assert feet[0] == pytest.approx(query[0] - (query[0] - mean) @ normal * normal, abs=1e-9)


def test_a_query_among_its_own_duplicates_stays():
    same = np.full((6, 3), 2.0)
    feet, _, widths = moving_planes(same[:1], same, np.arange(6)[None])
    assert np.array_equal(feet[0], same[0])
    assert widths[0] == 0
