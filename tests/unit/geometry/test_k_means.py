"""The start of expectation maximization against scikit-learn's k-means."""

import numpy as np
import pytest
from sklearn.cluster import KMeans

from lpcompare.geometry.k_means import k_means, nearest_centers


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("n_clusters", [1, 2, 7, 20])
def test_centres_are_those_of_scikit_learn(n_clusters, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(900, 3)) * rng.uniform(0.01, 3.0, 3) + rng.uniform(-50, 50, 3)
    expected = KMeans(n_clusters, n_init="auto", random_state=seed).fit(points)
    centers = k_means(points, n_clusters, seed)
    np.testing.assert_allclose(centers, expected.cluster_centers_, rtol=0, atol=1e-9)
    assert np.array_equal(nearest_centers(points, centers), expected.labels_)


def test_duplicates_and_as_many_clusters_as_places():
    places = np.array([[0.0, 0, 0], [1, 0, 0], [0, 5, 0], [7, 7, 7]])
    points = np.repeat(places, [1, 50, 3, 200], axis=0)
    centers = k_means(points, 4, 0)
    assert sorted(map(tuple, np.round(centers, 9))) == sorted(map(tuple, places))


def test_one_place():
    assert np.array_equal(k_means(np.full((5, 3), 2.5), 1, 3), [[2.5, 2.5, 2.5]])
