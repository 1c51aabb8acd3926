"""Incremental clustering: regions of equal size grow one after the other, and each gives its mean.

Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002, section 3.1.
A cluster begins with a seed and takes its nearest points until it has n_max of them, or until its surface
variation (eq. 5) is above sigma_max. The next seed is a neighbor of the cluster. Clusters that did not reach
half of either bound are dissolved: each of their points goes to the cluster of the nearest mean. The mean of a
cluster is a point of the result. So the result is as dense as the input, in proportion.

What the publication leaves open is decided here:

- A cluster grows over the graph of each point's 10 nearest points, nearest to the seed first, through points
  that no cluster has yet: so it is connected. The first seed is drawn at random. The next one is, of the
  points that the cluster touched and did not take, the one nearest to its mean; when there is none, the one
  that an earlier cluster touched first; when there is none, the first row without a cluster.
- n_max need not be whole: the limits of the clusters are rounded so that they keep it on average. It is the
  largest value found, by 10 bisections, that leaves at least as many clusters as points are asked for. The
  smallest clusters of those are dissolved too, equal ones at random, until the count is exact.
- There is no sigma_max unless ``max_variation`` gives one. Up to three points have no variation.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numba import njit

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Indices, Points, Simplification, Traits, Vector
from lpcompare_baselines._clusters import cluster_means

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="clustering",
    moves_points=True,
    keeps_attributes=False,
)

_NEIGHBORS = 10
_BISECTIONS = 10
_LARGEST = 4
"""Multiple of the mean size of a cluster up to which n_max is searched."""


def pauly_incremental(
    points: Points, target_count: int, *, rng: np.random.Generator, max_variation: float = np.inf
) -> Simplification:
    """Grow clusters of equal size and keep the mean of each.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the first seed, and which of equally small clusters is dissolved.
    max_variation : float, optional
        sigma_max, from 0 to 1/3: curved places then get smaller clusters.

    Returns
    -------
    Simplification
        New points.
    """
    center = bounding_box_center(points)
    labels = grow_clusters(points - center, target_count, max_variation, rng)
    return Simplification(cluster_means(points - center, labels) + center)


def grow_clusters(
    points: Points, target_count: int, max_variation: float, rng: np.random.Generator
) -> Indices:
    """Cluster of each point, shape (n,), from 0 to ``target_count`` - 1."""
    neighbors = nearest_others(points, _NEIGHBORS)[1]
    seed = int(rng.integers(len(points)))
    low, high = 1.0, max(1.0, _LARGEST * len(points) / target_count)
    labels, kept = np.arange(len(points)), np.arange(len(points))
    for _ in range(_BISECTIONS):
        size = float(np.sqrt(low * high))
        found, variations = _grow(points, neighbors, seed, size, max_variation)
        large = _large_enough(found, variations, size, max_variation)
        if len(large) >= target_count:
            low, labels, kept = size, found, large
        else:
            high = size
    sizes = np.bincount(labels)[kept]
    order = np.lexsort((rng.permutation(len(kept)), -sizes))
    return _dissolve(points, labels, np.sort(kept[order[:target_count]]))


def _large_enough(labels: Indices, variations: Vector, size: float, max_variation: float) -> Indices:
    """Clusters that reached half of a bound; all where none did."""
    small = (np.bincount(labels) < size / 2) & (variations < max_variation / 2)
    return np.flatnonzero(~small) if not small.all() else np.arange(len(small))


def _dissolve(points: Points, labels: Indices, kept: Indices) -> Indices:
    """Give the points of the clusters that are not kept to those of the nearest mean, and number anew."""
    numbers = np.full(labels.max() + 1, -1)
    numbers[kept] = np.arange(len(kept))
    renumbered = numbers[labels]
    free = renumbered < 0
    means = cluster_means(points[~free], renumbered[~free])
    renumbered[free] = Neighbors(means).query(points[free], 1)[1][:, 0]
    return renumbered


@njit(cache=True)
def _grow(points, neighbors, seed, size, max_variation):
    """Cluster of each point, shape (n,), strays among them, and the surface variation of each cluster."""
    n = len(points)
    labels, touched = np.full(n, -1), np.full(n, -1)
    variations = np.zeros(n)
    earlier, first_earlier, first_free, n_clusters, n_labelled = [seed], 0, 0, 0, 0
    while n_labelled < n:
        limit = int(size * (n_clusters + 1)) - int(size * n_clusters)
        rim = [(0.0, seed)]
        touched[seed] = n_clusters
        n_taken, first, second = 0, np.zeros(3), np.zeros((3, 3))
        while rim and n_taken < limit and variations[n_clusters] <= max_variation:
            row = heappop(rim)[1]
            labels[row] = n_clusters
            n_taken += 1
            offset = points[row] - points[seed]
            first += offset
            second += np.outer(offset, offset)
            if n_taken > 3 and max_variation < np.inf:
                values = np.linalg.eigvalsh(second - np.outer(first, first) / n_taken)
                variations[n_clusters] = max(values[0], 0.0) / values.sum() if values.sum() > 0 else 0.0
            for other in neighbors[row]:
                if labels[other] < 0 and touched[other] < n_clusters:
                    touched[other] = n_clusters
                    heappush(rim, (np.square(points[other] - points[seed]).sum(), other))
        n_labelled += n_taken
        n_clusters += 1
        if n_labelled == n:
            break
        mean, best = points[seed] + first / n_taken, np.inf
        seed = -1
        for _, row in rim:
            earlier.append(row)
            distance = np.square(points[row] - mean).sum()
            if distance < best:
                best, seed = distance, row
        while seed < 0 and first_earlier < len(earlier):
            if labels[earlier[first_earlier]] < 0:
                seed = earlier[first_earlier]
            first_earlier += 1
        while seed < 0:
            if labels[first_free] < 0:
                seed = first_free
            first_free += 1
    return labels, variations[:n_clusters]
