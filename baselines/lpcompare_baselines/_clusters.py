"""What stands for each cluster of a partition: its mean, or the point nearest to it."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices, Points


def cluster_means(points: Points, labels: Indices) -> Points:
    """Mean of each cluster's points, shape (m, 3), in the order of the labels 0 to m - 1."""
    center = points[0]
    sums = np.column_stack([np.bincount(labels, weights=axis) for axis in (points - center).T])
    return center + sums / np.bincount(labels)[:, None]


def nearest_members(points: Points, labels: Indices, means: Points) -> Indices:
    """Of each cluster, the row of the point nearest to the mean, ascending; the lowest row of equal ones."""
    squared = np.square(points - means[labels]).sum(axis=1)
    order = np.lexsort((squared, labels))
    return np.sort(order[np.flatnonzero(np.diff(labels[order], prepend=-1))])
