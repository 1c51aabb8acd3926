"""Boolean programme per cluster that keeps the cluster's density (Leal et al., density-preserving reading).

Leal, Leal and Sanchez-Torres (2017). Gaussian mixture clusters (eqs. 1-5), feature points by curvature
(eqs. 6-11), and in each cluster the selection whose mean inverse distance to the centroid is that of the
cluster: eqs. 12-26 with both densities averaged and k = 1, the reading under which the text's "maintains
the proportion of the density" can be met.
"""

from __future__ import annotations

import numpy as np

from lpcompare.paper.cluster_count import ClusterCountSetting
from lpcompare.paper.simplifier import LPSimplifier
from lpcompare.types import Points, Simplification, Traits

TRAITS = Traits(
    wraps="lpcompare (cvxpy, HiGHS)",
    source="Leal and others, A Linear Programming Approach for 3D Point Cloud Simplification, 2017",
)


def lp_density(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_clusters: ClusterCountSetting = 20,
    n_neighbors: int = 20,
    retention: str = "exact-count",
    feature_share: float = 0.4,
    density: str = "mean",
    solver: str = "highs",
    clusterer: str = "em",
    time_limit: float = 10.0,
    gap: float = 0.0,
) -> Simplification:
    """Keep ``target_count`` of the points; the settings are those of `lpcompare.LPSimplifier`.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n; under ``retention="keep-features"`` it sets the rate, and more points stay.
    rng : numpy.random.Generator

    Returns
    -------
    Simplification
        A subset of the input.
    """
    return (
        LPSimplifier(
            target_count=target_count,
            method="lp_density",
            n_clusters=n_clusters,
            n_neighbors=n_neighbors,
            retention=retention,
            feature_share=feature_share,
            density=density,
            solver=solver,
            clusterer=clusterer,
            time_limit=time_limit,
            gap=gap,
            random_state=rng,
        )
        .fit(points)
        .simplification_
    )
