"""Hierarchical clustering that keeps points: each cluster keeps the point nearest to its mean.

`lpcompare_baselines.pauly_hierarchical` with another representative, the one of CGAL's
hierarchy_simplify_point_set. With ``queue=False`` and the same two bounds both keep the same points, but for
clusters of two points: both are equally near to the mean, and rounding decides.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._clusters import nearest_members
from lpcompare_baselines.pauly_hierarchical import split_clusters

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="clustering",
)


def pauly_hierarchical_subset(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    queue: bool = True,
    max_size: float | None = None,
    max_variation: float | None = None,
) -> Simplification:
    """Split the cloud into clusters and keep the point nearest to the mean of each.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    queue, max_size, max_variation
        As in `lpcompare_baselines.pauly_hierarchical.pauly_hierarchical`.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    centered = about_center(points)
    indices = nearest_members(
        centered, *split_clusters(centered, target_count, queue, max_size, max_variation)
    )
    return Simplification(points[indices], indices)
