"""Hierarchical clustering: clusters are split across their longest axis, and each gives its mean.

Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002, section 3.1.
A cluster C is split when it holds more than n_max points, or when its surface variation (eq. 5: the least
eigenvalue of the covariance over the sum of all three) is above sigma_max. The plane of the split goes
through the mean, normal to the eigenvector of the largest eigenvalue. The mean of what is not split is a point
of the result.

For an exact count the publication keeps the clusters in a queue. What it leaves open is decided here:

- The key of the queue is max(|C| / n_max, sigma / sigma_max), the largest first. The queue is left when it
  holds as many clusters as points are asked for.
- n_max is twice the mean size, 2 n / target. sigma_max is the 90th percentile of the variation of the
  clusters that n_max alone would give.
- A point on the plane counts to the side that the normal points to, as in CGAL. A cluster that the plane does
  not divide, because its points coincide, comes last in the queue and is divided in two halves of its rows.

With ``queue=False`` the two bounds alone decide, as in CGAL's hierarchy_simplify_point_set; the count is then
what it comes to, and clusters that no plane divides stay whole.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numba import njit

from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Indices, Points, Simplification, Traits

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="clustering",
    moves_points=True,
    keeps_attributes=False,
)

_CURVED = 90
"""Percentile of the clusters' variation that is the bound on it."""


def pauly_hierarchical(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    queue: bool = True,
    max_size: float | None = None,
    max_variation: float | None = None,
) -> Simplification:
    """Split the cloud into clusters and keep the mean of each.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    queue : bool, optional
        Split the worst cluster first until the count is exact; otherwise, until both bounds hold.
    max_size : float, optional
        n_max; twice the mean number of points of a cluster by default.
    max_variation : float, optional
        sigma_max, from 0 to 1/3; by default from the clusters that ``max_size`` gives.

    Returns
    -------
    Simplification
        New points.
    """
    center = bounding_box_center(points)
    _, means = split_clusters(points - center, target_count, queue, max_size, max_variation)
    return Simplification(means + center)


def split_clusters(
    points: Points, target_count: int, queue: bool, max_size: float | None, max_variation: float | None
) -> tuple[Indices, Points]:
    """Cluster of each point, shape (n,), and the means, shape (m, 3); parameters as the method's."""
    size = 2 * len(points) / target_count if max_size is None else float(max_size)
    if max_variation is None:
        variations = _split(points, len(points), size, np.inf, 1.0)[2]
        max_variation = float(np.percentile(variations, _CURVED))
    # a bound of zero would leave no order among the clusters
    variation = max(float(max_variation), np.finfo(float).tiny)
    most, least_key = (target_count, -1.0) if queue else (len(points), 1.0)
    labels, means, _ = _split(points, most, size, variation, least_key)
    return labels, means


@njit(cache=True)
def _split(points, most_clusters, max_size, max_variation, least_key):
    """Split the cluster of largest key while that is above ``least_key`` and there are fewer than the most.

    Returns the cluster of each point, shape (n,), the mean of each cluster and its surface variation.
    """
    n = len(points)
    order, part = np.arange(n), np.empty(n, dtype=np.intp)
    begins, ends = np.zeros(most_clusters, dtype=np.intp), np.full(most_clusters, n)
    means, axes = np.empty((most_clusters, 3)), np.empty((most_clusters, 3))
    variations = np.empty(most_clusters)
    variations[0] = _describe(points, order, means[0], axes[0])
    waiting = [(-max(n / max_size, variations[0] / max_variation), 0)]
    n_clusters = 1
    while waiting and n_clusters < most_clusters:
        key, cluster = heappop(waiting)
        if -key <= least_key:
            break
        begin, end = begins[cluster], ends[cluster]
        middle = begin + _part(points, order[begin:end], part[begin:end], means[cluster], axes[cluster])
        if middle in (begin, end):
            if least_key >= 0:
                continue
            if key < 0:  # first those that a plane divides
                heappush(waiting, (0.0, cluster))
                continue
            middle = (begin + end) // 2
        ends[cluster], begins[n_clusters], ends[n_clusters] = middle, middle, end
        for child in (cluster, n_clusters):
            rows = order[begins[child] : ends[child]]
            variations[child] = _describe(points, rows, means[child], axes[child])
            if len(rows) > 1:
                key = max(len(rows) / max_size, variations[child] / max_variation)
                heappush(waiting, (-key, child))
        n_clusters += 1
    labels = np.empty(n, dtype=np.intp)
    for cluster in range(n_clusters):
        labels[order[begins[cluster] : ends[cluster]]] = cluster
    return labels, means[:n_clusters], variations[:n_clusters]


@njit(cache=True)
def _describe(points, rows, mean, axis):
    """Surface variation (eq. 5) of some points; fills in their mean and their longest axis."""
    mean[:] = 0.0
    for row in rows:
        mean += points[row]
    mean /= len(rows)
    covariance = np.zeros((3, 3))
    for row in rows:
        for i in range(3):
            for j in range(i + 1):
                covariance[i, j] += (points[row, i] - mean[i]) * (points[row, j] - mean[j])
    values, vectors = np.linalg.eigh(covariance)
    axis[:] = vectors[:, 2]
    total = values.sum()
    return max(values[0], 0.0) / total if total > 0 else 0.0


@njit(cache=True)
def _part(points, rows, part, mean, axis):
    """Sort rows in place: first those that the axis points to, then those behind; how many the first are."""
    n_first, n_second = 0, 0
    for row in rows:
        side = 0.0
        for i in range(3):
            side += (points[row, i] - mean[i]) * axis[i]
        if side < 0:
            part[n_second] = row
            n_second += 1
        else:
            rows[n_first] = row
            n_first += 1
    rows[n_first:] = part[:n_second]
    return n_first
