"""Moving planes, against their definition."""

import numpy as np
import pytest

from lpcompare.geometry.moving_planes import moving_planes


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
