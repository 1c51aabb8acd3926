"""Statistical outlier removal against its definition, and what `simplify` makes of it."""

import numpy as np
import pytest
from scipy.spatial import KDTree

import lpcompare
from lpcompare.errors import InputError
from lpcompare.simplify import outlier_mask


def sphere_with_outliers(n_points=3000, n_outliers=150, seed=0):
    rng = np.random.default_rng(seed)
    surface = rng.normal(size=(n_points, 3))
    surface /= np.linalg.norm(surface, axis=1, keepdims=True)
    far = rng.uniform(-3, 3, size=(4 * n_outliers, 3))
    far = far[np.abs(np.linalg.norm(far, axis=1) - 1) > 0.3][:n_outliers]
    return np.concatenate([surface, far]), np.arange(n_points + len(far)) >= n_points


def test_the_mask_is_what_the_definition_says():
    points, _ = sphere_with_outliers()
    means = KDTree(points).query(points, 13)[0][:, 1:].mean(axis=1)
    assert np.array_equal(outlier_mask(points, 1.5), means > means.mean() + 1.5 * means.std())


def test_most_outliers_are_found_and_few_points_of_the_surface():
    points, far = sphere_with_outliers()
    found = outlier_mask(points, 1.0)
    assert found[far].mean() > 0.9
    assert found[~far].mean() < 0.01


@pytest.mark.parametrize(
    "points", [np.zeros((1, 3)), np.ones((9, 3)), np.eye(3), np.arange(6.0).reshape(2, 3)]
)
def test_degenerate_clouds_lose_nothing(points):
    assert not outlier_mask(points, 2.0).any()


def test_simplify_keeps_none_and_counts_rows_in_the_input():
    points, far = sphere_with_outliers()
    points[5] = np.nan
    result = lpcompare.simplify(points, target_count=300, drop_invalid=True, drop_outliers=1.0, n_clusters=4)
    outliers = result.info["outliers"]
    assert np.isin(np.flatnonzero(far), outliers).mean() > 0.9
    assert not np.isin(result.indices, outliers).any()
    assert np.array_equal(points[result.indices], result.points)
    assert result.info["n_left_out"] == 1
    assert len(result) == 300


def test_a_negative_limit_is_refused():
    with pytest.raises(InputError, match="drop_outliers"):
        lpcompare.simplify(np.eye(3), target_count=1, drop_outliers=-1)
