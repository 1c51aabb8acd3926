"""Stage 1: the fast core against scikit-learn's mixture, and its laws."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.mixture import GaussianMixture
from threadpoolctl import threadpool_limits

from lpcompare.geometry.scale import normalize
from lpcompare.paper.clustering import assign, cluster_points, start_labels


def wavy_sphere(n_points, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n_points, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * (1 + 0.2 * np.sin(5 * points[:, :1]) * np.cos(4 * points[:, 1:2]))


def slab(n_points, seed=0):
    return np.random.default_rng(seed).uniform(size=(n_points, 3)) * [4.0, 2.0, 0.05]


def plane(n_points, seed=0):
    return slab(n_points, seed) * [1, 1, 0]


def blobs(n_points, seed=0):
    rng = np.random.default_rng(seed)
    centers = rng.normal(size=(12, 3)) * 5
    return centers[rng.integers(12, size=n_points)] + rng.normal(size=(n_points, 3))


def reference_from(points, labels):
    """scikit-learn's mixture started from the same hard assignment."""
    groups = [points[labels == c] for c in range(labels.max() + 1)]
    covariances = np.array([np.cov(g.T, bias=True) + 1e-6 * np.eye(3) for g in groups])
    model = GaussianMixture(
        len(groups),
        weights_init=np.array([len(g) for g in groups]) / len(points),
        means_init=np.array([g.mean(axis=0) for g in groups]),
        precisions_init=np.linalg.inv(covariances),
    )
    with threadpool_limits(1):
        return model.fit(points)


@pytest.mark.parametrize("n_clusters", [15, 20, 25])
@pytest.mark.parametrize("shape", [wavy_sphere, slab, plane, blobs])
def test_reaches_the_log_likelihood_of_scikit_learn_from_the_same_start(shape, n_clusters):
    points = normalize(shape(2000))[0]
    labels = start_labels(points, n_clusters, np.random.default_rng(0))
    ours = cluster_points(points, n_clusters, np.random.default_rng(0), start=labels)
    reference = reference_from(points, labels)
    assert len(ours.log_likelihoods) == reference.n_iter_
    assert ours.log_likelihoods[-1] / len(points) == pytest.approx(reference.lower_bound_, rel=1e-6)
    assert np.allclose(ours.means, reference.means_, atol=1e-6)
    assert np.allclose(ours.covariances, reference.covariances_, atol=1e-6)
    assert np.mean(ours.labels == reference.predict(points)) > 0.9999
    assert np.allclose(ours.responsibilities(points), reference.predict_proba(points), atol=1e-5)


@pytest.mark.shared
@pytest.mark.parametrize("n_clusters", [15, 20, 25])
@pytest.mark.parametrize("name", ["stanford-bunny", "nefertiti", "ogre"])
def test_reaches_the_log_likelihood_of_scikit_learn_on_real_scans(shared_models, name, n_clusters):
    points = read_vertices(shared_models / "upstream" / f"{name}.obj")[::12]
    points = normalize(points)[0]
    labels = start_labels(points, n_clusters, np.random.default_rng(0))
    ours = cluster_points(points, n_clusters, np.random.default_rng(0), start=labels)
    reference = reference_from(points, labels)
    assert ours.log_likelihoods[-1] / len(points) == pytest.approx(reference.lower_bound_, rel=1e-6)


def read_vertices(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)


def cluster_points_with_sklearn(points, n_clusters, rng):
    """scikit-learn's mixture with its defaults: its log-likelihoods and labels."""
    model = GaussianMixture(n_clusters, random_state=int(rng.integers(2**31)))
    labels = model.fit_predict(points)
    return SimpleNamespace(log_likelihoods=len(points) * np.array(model.lower_bounds_), labels=labels)


def test_own_start_is_as_good_as_that_of_scikit_learn():
    points = normalize(wavy_sphere(20_000))[0]
    with threadpool_limits(1):
        ours, theirs = (
            [fit(points, 8, np.random.default_rng(seed)).log_likelihoods[-1] for seed in range(3)]
            for fit in (cluster_points, cluster_points_with_sklearn)
        )
    assert np.median(ours) / len(points) >= np.median(theirs) / len(points) - 0.02


@pytest.mark.parametrize("seed", range(3))
def test_same_seed_gives_the_fit_of_scikit_learn(seed):
    points = normalize(wavy_sphere(3000))[0]
    with threadpool_limits(1):
        ours = cluster_points(points, 6, np.random.default_rng(seed))
        theirs = cluster_points_with_sklearn(points, 6, np.random.default_rng(seed))
    assert np.allclose(ours.log_likelihoods, theirs.log_likelihoods, rtol=1e-9)
    assert np.mean(ours.labels == theirs.labels) > 0.999


@given(seed=st.integers(0, 10_000), n_clusters=st.integers(1, 8), n_points=st.integers(1, 200))
def test_log_likelihood_never_falls_and_every_point_has_a_component(seed, n_clusters, n_points):
    points = normalize(np.random.default_rng(seed).normal(size=(n_points, 3)))[0]
    mixture = cluster_points(points, n_clusters, np.random.default_rng(seed))
    assert (np.diff(mixture.log_likelihoods) >= -1e-6 * n_points).all()
    assert mixture.labels.shape == (n_points,)
    assert 0 <= mixture.labels.min() <= mixture.labels.max() < mixture.n_clusters <= n_clusters
    assert mixture.weights.sum() == pytest.approx(1)
    assert mixture.responsibilities(points).sum(axis=1) == pytest.approx(1)


def test_labels_are_the_most_probable_components():
    points = normalize(blobs(2000))[0]
    mixture = cluster_points(points, 12, np.random.default_rng(1))
    assert np.array_equal(mixture.labels, mixture.responsibilities(points).argmax(axis=1))
    assert np.array_equal(mixture.labels, assign(points, mixture))


def test_rows_far_from_every_component_count_by_their_log_density():
    points = np.vstack([np.random.default_rng(0).normal(size=(500, 3)) * 0.01, [[40.0, 0, 0]]])
    labels = np.arange(501) % 2
    ours = cluster_points(points, 2, np.random.default_rng(0), start=labels, max_iterations=2)
    reference = GaussianMixture(2, max_iter=1)
    first = cluster_points(points, 2, np.random.default_rng(0), start=labels, max_iterations=1)
    reference.weights_, reference.means_, reference.covariances_ = (
        first.weights,
        first.means,
        first.covariances,
    )
    reference.precisions_cholesky_ = np.linalg.cholesky(np.linalg.inv(first.covariances))
    assert ours.log_likelihoods[1] == pytest.approx(reference.score(points) * 501, rel=1e-9)


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((30, 3)),
        np.repeat(np.eye(3), 20, axis=0),
        np.outer(np.arange(50.0), [1, 2, 3]),
        np.random.default_rng(0).uniform(size=(60, 3)) * [1, 1, 0],
        np.random.default_rng(0).uniform(size=(3, 3)),
    ],
    ids=["all equal", "three places", "line", "plane", "fewer than components"],
)
def test_components_do_not_collapse(points):
    mixture = cluster_points(normalize(points)[0], 8, np.random.default_rng(0))
    assert mixture.n_clusters <= min(8, len(np.unique(points, axis=0)))
    assert np.isfinite(mixture.covariances).all()
    assert (np.linalg.eigvalsh(mixture.covariances) > 0).all()


def test_a_large_cloud_is_fitted_on_a_sample_and_the_fit_labels_every_point():
    points = normalize(blobs(9000))[0]
    full = cluster_points(points, 12, np.random.default_rng(3))
    sampled = cluster_points(points, 12, np.random.default_rng(3), fit_limit=3000)
    assert sampled.labels.shape == (9000,)
    likelihoods = [GaussianScore(m).mean(points) for m in (full, sampled)]
    assert likelihoods[1] == pytest.approx(likelihoods[0], abs=0.05)


class GaussianScore:
    """Mean log-likelihood of points under a mixture, by scipy."""

    def __init__(self, mixture):
        from scipy.stats import multivariate_normal

        parts = zip(mixture.means, mixture.covariances, strict=True)
        self._components = [multivariate_normal(m, c) for m, c in parts]
        self._weights = mixture.weights

    def mean(self, points):
        densities = sum(w * c.pdf(points) for w, c in zip(self._weights, self._components, strict=True))
        return np.log(densities).mean()


def test_one_thread_and_two_give_the_same_fit(monkeypatch):
    points = normalize(wavy_sphere(20_000))[0]
    fits = []
    for threads in ("1", "2"):
        monkeypatch.setenv("LPCOMPARE_THREADS", threads)
        fits.append(cluster_points(points, 10, np.random.default_rng(0)))
    assert np.array_equal(fits[0].log_likelihoods, fits[1].log_likelihoods)
    assert np.array_equal(fits[0].labels, fits[1].labels)
