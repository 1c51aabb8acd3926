"""MLS distance: how far the originals are from the moving least squares surface of the reduced points.

The error measure of Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces,
Visualization 2002, eqs. 9 and 10: the largest and the mean distance d(q, S') of points q of the original
surface to the surface S' of the reduced cloud, found by MLS projection with a linear basis. The publication
gives both as a share of the bounding-box diagonal; here they stand in % of it.

Left open there, decided here: k, the number of nearest reduced points that carry the surface, is 12. The
width h of the Gaussian weight is a third of the distance to the farthest of them, as in their section 2.2.
The points q are the originals themselves, where the publication samples the original surface anew. The foot
of q is found in 5 rounds of `lpcompare.geometry.moving_planes.moving_planes`. It is eq. 27 of the 2017 paper with
weights: near points count more, so that the surface nearly passes through the reduced points.
"""

from __future__ import annotations

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column, Vector

COLUMNS = {
    "mls_distance_pct": Column("% of diagonal", "Mean distance of an original to the MLS surface"),
    "mls_distance_max_pct": Column("% of diagonal", "Largest distance of an original to the MLS surface"),
}

_NEIGHBORS = 12


def mls_distance(comparison: Comparison) -> dict[str, float]:
    """Mean and largest distance of the originals to the MLS surface of the reduced points.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    distances = mls_distances(comparison)
    return {
        "mls_distance_pct": comparison.percent(float(distances.mean())),
        "mls_distance_max_pct": comparison.percent(float(distances.max())),
    }


def mls_distances(comparison: Comparison, n_neighbors: int = _NEIGHBORS) -> Vector:
    """Eqs. 9 and 10 before the mean: distance of each original to the surface, shape (n,), in model units."""
    from lpcompare.geometry.moving_planes import moving_planes

    feet, _, _ = moving_planes(comparison.original, comparison.simplified, comparison.nearest(n_neighbors))
    return np.linalg.norm(comparison.original - feet, axis=1)
