"""The Gaussian process of gp_subset, against its dense formulas, and what the method keeps."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from lpcompare.geometry.graphs import gaussian_graph
from lpcompare_baselines.gp_subset import gp_subset, likelihood, posterior, smooth_vectors, spread


def rng(seed=0):
    return np.random.default_rng(seed)


def test_the_posterior_is_that_of_the_dense_process():
    features, noise, rows = rng().normal(size=(40, 6)), 0.3, np.arange(0, 40, 3)
    values = rng(1).normal(size=len(rows))
    kernel = features @ features.T
    inverse = np.linalg.inv(kernel[np.ix_(rows, rows)] + noise * np.eye(len(rows)))
    across = kernel[:, rows] @ inverse
    mean, variance = posterior(features, noise, rows, values)
    assert np.allclose(mean, across @ values)
    assert np.allclose(variance, np.diag(kernel) - np.einsum("ij,ij->i", across, kernel[:, rows]))


def test_the_likelihood_is_that_of_the_normal_distribution():
    features, values, noise = rng().normal(size=(30, 4)), rng(1).normal(size=30), 0.2
    whole = multivariate_normal(np.zeros(30), features @ features.T + noise * np.eye(30)).logpdf(values)
    assert likelihood(features, values, noise) == pytest.approx(whole + 15 * np.log(2 * np.pi))


@pytest.mark.parametrize("n", [150, 600])
def test_the_vectors_are_the_smoothest_of_the_laplacian(n):
    graph = gaussian_graph(rng().normal(size=(n, 3)), 15)
    eigenvalues, vectors = smooth_vectors(graph)
    roots = 1 / np.sqrt(graph.sum(axis=1))
    laplacian = np.eye(n) - roots[:, None] * graph.toarray() * roots
    assert np.allclose(eigenvalues, np.linalg.eigvalsh(laplacian)[:20], atol=1e-8)
    assert np.allclose(laplacian @ vectors, vectors * eigenvalues, atol=1e-6)


def test_values_are_spread_exactly_where_the_landmarks_are():
    points, values = rng().normal(size=(300, 3)), rng(1).normal(size=(50, 2))
    landmarks = np.arange(50)
    assert np.allclose(spread(points, landmarks, values)[:50], values, atol=1e-6)


def test_a_bump_in_a_plane_is_crowded():
    points = np.c_[rng(3).random((4000, 2)), np.zeros(4000)]
    on_bump = np.hypot(*(points[:, :2] - 0.5).T) < 0.1
    points[on_bump, 2] = 0.02 * rng(4).random(on_bump.sum())
    kept = gp_subset(points, 400, rng=rng()).indices
    assert on_bump[kept].mean() > 3 * on_bump.mean()
