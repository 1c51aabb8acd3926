"""Hierarchical clustering of Pauly, Gross and Kobbelt: bounds, counts, and CGAL's clusters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lpcompare as lp
from lpcompare.geometry.scale import bounding_box_center
from lpcompare_baselines._clusters import nearest_members
from lpcompare_baselines.pauly_hierarchical import pauly_hierarchical, split_clusters
from lpcompare_baselines.pauly_hierarchical_subset import pauly_hierarchical_subset

RNG = np.random.default_rng(0)


def variation(points):
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) ** 2
    return values[2] / values.sum() if len(points) > 3 else 0.0


def wavy(n, seed=0):
    """Half a plane, half waves."""
    x, y = np.random.default_rng(seed).uniform(size=(2, n))
    return np.column_stack([2 * x - 1, y, np.where(x > 0.5, 0.02 * np.sin(60 * x), 0.0)])


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(2, 40), st.floats(0.001, 0.2))
def test_without_the_queue_every_cluster_keeps_both_bounds(seed, size, bound):
    points = np.random.default_rng(seed).normal(size=(300, 3)) * [3.0, 1.0, 0.3]
    labels, means = split_clusters(points, 1, False, size, bound)
    for label, mean in enumerate(means):
        inside = points[labels == label]
        assert len(inside) <= size
        assert variation(inside) <= bound * (1 + 1e-9)
        assert mean == pytest.approx(inside.mean(axis=0))


def test_without_the_queue_the_first_split_is_across_the_longest_axis():
    points = np.random.default_rng(1).normal(size=(500, 3)) * [9.0, 1.0, 1.0]
    labels, means = split_clusters(points, 1, False, 400, 1 / 3)
    axis = np.linalg.svd(points - points.mean(axis=0))[2][0]
    side = (points - points.mean(axis=0)) @ axis < 0
    assert len(means) == 2
    assert len(np.unique(labels[side])) == len(np.unique(labels[~side])) == 1


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(1, 60), st.data())
def test_with_the_queue_the_count_is_exact_also_among_duplicates(seed, n, data):
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 3, size=(n, 3)).astype(float)
    target = data.draw(st.integers(1, n))
    labels, means = split_clusters(points, target, True, None, None)
    assert np.array_equal(np.unique(labels), np.arange(target))
    assert len(means) == target
    kept = pauly_hierarchical_subset(points, target, rng=rng)
    assert len(np.unique(kept.indices)) == target


def test_a_plane_is_cut_into_clusters_of_similar_size():
    points = np.column_stack([np.random.default_rng(0).uniform(size=(4000, 2)), np.zeros(4000)])
    labels, _ = split_clusters(points, 1, False, 40, 0.1)
    assert np.bincount(labels).max() <= 40
    assert np.bincount(labels).min() > 10


def test_curved_places_keep_more_than_flat_ones():
    share = []
    for bound in (1 / 3, 0.001):
        kept = pauly_hierarchical(wavy(8000), 800, rng=RNG, max_variation=bound).points
        share.append((kept[:, 0] > 0).mean())
    assert share[0] == pytest.approx(0.5, abs=0.05)
    assert share[1] > 0.6


def test_a_mean_lies_in_its_cluster_and_the_nearest_point_beside_it():
    points = wavy(2000) + np.array([5e5, 5e6, 100.0])
    means = pauly_hierarchical(points, 200, rng=RNG).points
    kept = pauly_hierarchical_subset(points, 200, rng=RNG)
    centered = points - bounding_box_center(points)
    labels, _ = split_clusters(centered, 200, True, None, None)
    for label in range(200):
        members = np.flatnonzero(labels == label)
        assert means[label] == pytest.approx(points[members].mean(axis=0), abs=1e-6)
        (row,) = np.intersect1d(members, kept.indices)
        distances = np.linalg.norm(points[members] - means[label], axis=1)
        assert np.linalg.norm(points[row] - means[label]) == pytest.approx(distances.min(), abs=1e-6)


MODELS = ["upstream/stanford-bunny.obj", "upstream/igea.ply", "scans/lidar-room-56159.ply"]


@pytest.mark.shared
@pytest.mark.parametrize("size_and_variation", [(10, 1 / 3), (100, 0.001), (1000, 0.01)], ids=str)
@pytest.mark.parametrize("model", MODELS)
def test_the_clusters_are_those_of_cgal(model, size_and_variation, shared_models):
    """The kept points are the same, but in clusters of two: those are equally near to their mean."""
    cgal = pytest.importorskip("CGAL.CGAL_Point_set_processing_3")
    from lpcompare_baselines._cgal import point_set, rows_of

    points = lp.read(shared_models / model).points
    points = points - bounding_box_center(points)
    cloud = point_set(points)
    cgal.hierarchy_simplify_point_set(cloud, *size_and_variation)
    theirs = rows_of(cloud)
    labels, means = split_clusters(points, 1, False, *size_and_variation)
    ours = nearest_members(points, labels, means)
    assert np.array_equal(np.sort(labels[theirs]), np.arange(len(means))), "one of each cluster"
    large = np.bincount(labels) > 2
    assert np.isin(ours[large[labels[ours]]], theirs).mean() >= 0.999
    if size_and_variation[1] == 1 / 3:
        assert np.isin(ours, theirs).mean() >= 0.999
