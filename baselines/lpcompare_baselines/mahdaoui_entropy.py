"""Clusters of least entropy are deleted, the whole cluster at once: a reading of Mahdaoui and Sbai 2020.

Mahdaoui and Sbai, 3D point cloud simplification based on k-nearest neighbor and clustering, Advances in
Multimedia 2020. Only the abstract could be read: k-means to small clusters, the entropy of each from a density
estimated by nearest neighbors, and clusters of minimal entropy are deleted.

1. k-means: as many clusters as leave 30 points to each, from points drawn at random, 10 rounds.
2. The density of a point is k / (n V), V the disc whose radius is the distance to its 8th nearest.
3. The entropy of a cluster is H = - mean of log density over its points.
4. Clusters go in the order of their entropy, the least first, until the count is reached; of the last one the
   densest points go.

Decisions: all the numbers above. The dimension of V changes H for all clusters alike, so not the order. A
constant of the density is left out for the same reason. To delete whole clusters makes holes by construction.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Indices, Points, Simplification, Traits

TRAITS = Traits(
    wraps="numpy",
    source="Mahdaoui and Sbai, 3D point cloud simplification based on k-nearest neighbor and clustering, "
    "Advances in Multimedia 2020",
    licence="GPL-3.0-or-later",
    family="clustering",
    reading=True,
)

_ROUNDS = 10


def mahdaoui_entropy(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    cluster_size: int = 30,
    n_neighbors: int = 8,
) -> Simplification:
    """Keep the points that are left when the clusters of least entropy have been deleted.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the first centers of k-means.
    cluster_size : int, optional
        Points per cluster, in the mean.
    n_neighbors : int, optional
        Nearest points of the density estimate.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    distances, _ = nearest_others(points, n_neighbors)
    radii = distances[:, -1] if distances.shape[1] else np.ones(len(points))
    sparseness = np.log(np.maximum(radii, np.finfo(float).tiny))
    labels = cluster(points, max(1, len(points) // cluster_size), rng)
    entropies = np.bincount(labels, sparseness) / np.maximum(np.bincount(labels), 1)
    order = np.lexsort((np.arange(len(points)), sparseness, labels, entropies[labels]))
    indices = np.sort(order[len(points) - target_count :])
    return Simplification(points[indices], indices)


def cluster(points: Points, n_clusters: int, rng: np.random.Generator) -> Indices:
    """Cluster of each point by k-means, shape (n,); a center that no point is nearest to stays where it is."""
    centers = points[rng.choice(len(points), n_clusters, replace=False)]
    for _ in range(_ROUNDS):
        labels = Neighbors(centers).query(points, 1)[1][:, 0]
        sizes = np.bincount(labels, minlength=n_clusters)
        sums = np.column_stack([np.bincount(labels, column, n_clusters) for column in points.T])
        centers = np.where(sizes[:, None] > 0, sums / np.maximum(sizes, 1)[:, None], centers)
    return Neighbors(centers).query(points, 1)[1][:, 0]
