"""n_clusters="auto"."""

import numpy as np
import pytest

import lpcompare
from lpcompare.estimators import LPSimplifier
from lpcompare.paper.cluster_count import CANDIDATES, choose_n_clusters


def blobs(n_blobs, seed=0, size=300):
    rng = np.random.default_rng(seed)
    centers = rng.permutation(np.stack(np.meshgrid(*[np.arange(3.0)] * 3), axis=-1).reshape(-1, 3))[:n_blobs]
    cloud = np.concatenate([c + 0.05 * rng.normal(size=(size, 3)) for c in centers])
    cloud -= cloud.mean(axis=0)
    return cloud / np.sqrt(np.mean(np.sum(cloud**2, axis=1)))


@pytest.mark.parametrize("n_blobs", [5, 8, 12])
def test_finds_separate_gaussians_almost(n_blobs):
    count = choose_n_clusters(blobs(n_blobs), np.random.default_rng(0))
    position = CANDIDATES.index(n_blobs)
    assert count.n_clusters in CANDIDATES[position : position + 3]


def test_the_curve_is_there_and_repeats():
    first, second = (choose_n_clusters(blobs(5), np.random.default_rng(3)) for _ in range(2))
    assert len(first.criteria) == len(first.candidates) == len(CANDIDATES)
    assert np.array_equal(first.criteria, second.criteria)
    assert first.criteria[first.candidates.index(first.n_clusters)] == first.criteria.min()


def test_a_tiny_cloud_is_one_cluster():
    assert choose_n_clusters(np.zeros((30, 3)), np.random.default_rng(0)).n_clusters == 1


@pytest.mark.parametrize("method", ["lp_density", "lp_uniform"])
def test_auto_reaches_the_methods(method):
    result = lpcompare.simplify(blobs(8), target_count=100, method=method, n_clusters="auto")
    assert 5 <= result.info["n_clusters"] <= 40
    assert len(result) == 100


def test_the_estimator_keeps_the_curve():
    fitted = LPSimplifier(target_count=50, n_clusters="auto").fit(blobs(5))
    assert fitted.cluster_count_.n_clusters == fitted.mixture_.n_clusters
