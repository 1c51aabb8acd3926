"""Density objective Z (eq. 14): how far each cluster's density is from that of the original.

Leal, Leal and Sanchez-Torres (2017), eqs. 12-15, with densities as means of the inverse distance to the
cluster's centroid and k = 1, the reading that a subset can reach; Z is divided by the original density. The
clusters are the metric's own, the same for every method: k-means with 20 clusters and a fixed seed on the
original. So a method that keeps the density of other clusters exactly is not at zero here.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column, Points, Vector

COLUMNS = {
    "density_objective_pct": Column("% of density", "Density objective Z (eq. 14), mean over 20 clusters"),
    "density_objective_max_pct": Column("% of density", "Density objective Z (eq. 14), worst cluster"),
}

_N_CLUSTERS = 20
_SAMPLE = 5000
_NEAREST = 1e-3
"""Share of a cluster's root mean square distance below which a point counts as that near to the centroid."""


def density_objective(comparison: Comparison) -> dict[str, float]:
    """|D_cr - D_c| / D_c, in %, mean and largest over the clusters; 100 for a cluster left empty.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    labels, centers = _clusters(comparison.original)
    reduced_labels = labels[comparison.backward_nearest]
    values = []
    for label, center in enumerate(centers):
        inside = _distances(comparison.original[labels == label], center)
        floor = _NEAREST * float(np.sqrt(np.square(inside).mean()))
        if floor == 0:
            continue
        kept = _distances(comparison.simplified[reduced_labels == label], center)
        values.append(abs(_density(kept, floor) / _density(inside, floor) - 1))
    return {
        "density_objective_pct": 100 * float(np.mean(values or [0.0])),
        "density_objective_max_pct": 100 * float(np.max(values or [0.0])),
    }


def _clusters(points: Points) -> tuple[NDArray[np.intp], Points]:
    """Cluster of each point, shape (n,), and the clusters' centroids; found on a subsample."""
    from scipy.cluster.vq import kmeans2

    rng = np.random.default_rng(0)
    sample = points[rng.choice(len(points), min(_SAMPLE, len(points)), replace=False)]
    n_distinct = len(np.unique(sample, axis=0))
    with warnings.catch_warnings():
        # a cluster that k-means leaves empty is dropped below
        warnings.filterwarnings("ignore", "One of the clusters is empty")
        found, _ = kmeans2(sample, min(_N_CLUSTERS, n_distinct), iter=20, minit="++", rng=rng)
    nearest = Neighbors(found).query(points, 1)[1][:, 0]
    labels = np.unique(nearest, return_inverse=True)[1].ravel()
    return labels, np.array([points[labels == label].mean(axis=0) for label in range(labels.max() + 1)])


def _distances(points: Points, center: Vector) -> Vector:
    return np.linalg.norm(points - center, axis=1)


def _density(distances: Vector, floor: float) -> float:
    """Mean inverse distance (eq. 15); 0 without points."""
    return float(np.mean(1 / np.maximum(distances, floor))) if len(distances) else 0.0
