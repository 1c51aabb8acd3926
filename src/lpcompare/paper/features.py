"""Stage 2, second half: points more curved than the mean of their cluster (rules a and b of the paper)."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices, Mask, Vector

_ROUNDING = 1e-9
_FLAT = 1e-7


def feature_mask(absolute_curvature: Vector, labels: Indices) -> Mask:
    """Mark the points with A_i above the mean A of their cluster.

    Parameters
    ----------
    absolute_curvature : ndarray, shape (n,)
        A of eq. 11, of the normalised cloud.
    labels : ndarray of int, shape (n,)
        Cluster of each point.

    Returns
    -------
    ndarray of bool, shape (n,)
        An excess within rounding, as on a plane or an exact sphere, does not make a feature.
    """
    counts = np.maximum(np.bincount(labels), 1)
    means = np.bincount(labels, absolute_curvature) / counts
    return above_means(absolute_curvature, means, labels)


def above_means(absolute_curvature: Vector, means: Vector, labels: Indices) -> Mask:
    """`feature_mask` of some points of clusters whose mean A (K,) is known."""
    return absolute_curvature > (means * (1 + _ROUNDING) + _FLAT)[labels]
