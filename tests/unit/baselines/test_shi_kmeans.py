"""Clusters split where normals differ; rims kept."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from lpcompare.registry import METHODS
from lpcompare_baselines.shi_kmeans import cover, largest_deviation, two_means


def thin(points, m, **settings):
    return METHODS.get("shi_kmeans")(points, m, rng=np.random.default_rng(0), **settings)


def random_normals(n, seed=0):
    normals = np.random.default_rng(seed).normal(size=(n, 3))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize("n", [1, 2, 5, 40, 64])
def test_largest_deviation_is_that_of_all_pairs(n):
    normals = random_normals(n, n)
    value, first, second = largest_deviation(normals, np.arange(n))
    cosines = np.abs(normals @ normals.T)
    assert value == pytest.approx(np.sqrt(max(1 - cosines.min(), 0)), abs=1e-7)
    assert abs(normals[first] @ normals[second]) == pytest.approx(cosines.min(), abs=1e-12)


def test_two_means_parts_two_heaps_and_halves_equal_points():
    rng = np.random.default_rng(1)
    points = np.vstack([rng.random((20, 3)), rng.random((30, 3)) + 5])
    members = rng.permutation(50)
    size = two_means(points, members, 0, int(np.flatnonzero((members < 20) != (members[0] < 20))[0]))
    assert len({m < 20 for m in members[:size]}) == len({m < 20 for m in members[size:]}) == 1
    assert two_means(np.ones((9, 3)), np.arange(9), 0, 1) == 4


def test_every_point_is_within_the_interval_of_the_point_that_began_its_cluster():
    points = np.random.default_rng(2).random((500, 3))
    cluster = cover(points, KDTree(points), 0.2)
    begins = np.unique(cluster, return_index=True)[1]
    assert (np.linalg.norm(points - points[begins][cluster], axis=1) <= 0.2).all()
    apart = np.linalg.norm(points[begins][:, None] - points[begins], axis=2) + np.eye(len(begins))
    assert apart.min() > 0.2


def test_rough_places_get_more_points_and_the_deviation_falls_with_the_count():
    flat = np.random.default_rng(3).random((6000, 2)) * [2, 1]
    points = np.column_stack([flat, np.where(flat[:, 0] > 1, 0.05 * np.sin(40 * flat[:, 0]), 0.0)])
    few, many = thin(points, 300), thin(points, 900)
    assert (points[few.indices, 0] > 1).mean() > 0.55
    assert many.info["normal_deviation"] < few.info["normal_deviation"]


def test_on_a_plane_the_clusters_are_of_like_size():
    flat = np.random.default_rng(4).random((4000, 2))
    kept = thin(np.column_stack([flat, np.zeros(4000)]), 400, rim_share=0.0).points
    nearest = KDTree(kept).query(kept, 2)[0][:, 1]
    assert nearest.std() / nearest.mean() < 0.4


def test_the_rim_of_a_disc_stays():
    rng = np.random.default_rng(5)
    radius, angle = np.sqrt(rng.random(3000)), rng.random(3000) * 2 * np.pi
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(3000)])
    rim = points[radius > 0.985]
    far = {
        share: KDTree(thin(points, 400, rim_share=share).points).query(rim)[0].max() for share in (0.0, 0.25)
    }
    spacing_of_result = np.sqrt(np.pi / 400)
    assert far[0.25] <= spacing_of_result
    assert far[0.25] < 0.95 * far[0.0]
