"""Chamfer distance: the mean distances of both ways, added.

Fan, Su and Guibas, A point set generation network for 3D object reconstruction from a single image, CVPR
2017. Authors square the distances or not; here both are given: unsquared in % of the diagonal, and squared as
they define it, in square model units. For a subset the way back is zero: the two are then `mean_distance` and
D1 again. They stand here because papers quote them, and are not counted as witnesses of their own.
"""

from __future__ import annotations

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "chamfer_pct": Column(
        "% of diagonal",
        "Chamfer distance, unsquared: both mean distances added",
        alias="mean_distance_pct",
    ),
    "chamfer_squared": Column(
        "square model units", "Chamfer distance: both mean squares added", alias="d1_mse"
    ),
}


def chamfer(comparison: Comparison) -> dict[str, float]:
    """Sum over both ways of the mean nearest-neighbour distance, and of its mean square.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    ways = comparison.forward_distances, comparison.backward_distances
    return {
        "chamfer_pct": comparison.percent(float(sum(d.mean() for d in ways))),
        "chamfer_squared": float(sum(np.square(d).mean() for d in ways)),
    }
