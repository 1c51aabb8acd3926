"""Intrinsic farthest point sampling with more points where the surface varies.

The feature-sensitive form of `moenning_geodesic`, which names the source and the decisions. The front of a sample
is slow where the surface variation is high, so that more samples are needed there. The authors leave the weight to
the user; here the speed is ``1 / (1 + s)``, with the surface variation s in units of its mean.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines.moenning_geodesic import moenning_geodesic

TRAITS = Traits(
    wraps="lpcompare (scipy, numba)",
    source="Moenning and Dodgson, A new point cloud simplification algorithm, "
    "3rd IASTED Conference on Visualization, Imaging and Image Processing, 2003 (abstracts)",
    family="curvature",
    progressive=True,
    reading=True,
)


def moenning_features(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 10,
    feature_weight: float = 1.0,
) -> Simplification:
    """Keep the first ``target_count`` points of the feature-sensitive order.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Neighbors of a point in the graph.
    feature_weight : float, optional
        How much more points rough places get; 0 is uniform.

    Returns
    -------
    Simplification
        A subset of the input, with the ``info`` of `moenning_geodesic`.
    """
    return moenning_geodesic(
        points, target_count, rng=rng, n_neighbors=n_neighbors, feature_weight=feature_weight
    )
