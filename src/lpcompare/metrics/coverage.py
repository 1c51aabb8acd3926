"""Coverage: how far the originals are from the nearest kept point, as a radius that leaves no hole.

The largest distance is the covering radius of the k-centre problem (Gonzalez, Clustering to minimize the
maximum intercluster distance, Theoretical Computer Science 38, 1985), which farthest point sampling keeps
within twice its least value.
"""

from __future__ import annotations

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "coverage_mean_pct": Column("% of diagonal", "Mean distance of an original to the nearest kept point"),
    "coverage_max_pct": Column(
        "% of diagonal", "Covering radius: largest distance to the nearest kept point"
    ),
}


def coverage(comparison: Comparison) -> dict[str, float]:
    """Mean and largest distance of the originals to the nearest kept point.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    distances = comparison.forward_distances
    return {
        "coverage_mean_pct": comparison.percent(float(np.mean(distances))),
        "coverage_max_pct": comparison.percent(float(np.max(distances))),
    }
