"""Incremental clustering that keeps points: each region keeps the point nearest to its mean.

`lpcompare_baselines.pauly_incremental` with another representative: "typically" the mean, as the publication
says, and here a point of the input.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._clusters import cluster_means, nearest_members
from lpcompare_baselines.pauly_incremental import grow_clusters

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="clustering",
)


def pauly_incremental_subset(
    points: Points, target_count: int, *, rng: np.random.Generator, max_variation: float = np.inf
) -> Simplification:
    """Grow clusters of equal size and keep the point nearest to the mean of each.

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
        A subset of the input.
    """
    centered = about_center(points)
    labels = grow_clusters(centered, target_count, max_variation, rng)
    indices = nearest_members(centered, labels, cluster_means(centered, labels))
    return Simplification(points[indices], indices)
