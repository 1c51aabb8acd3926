"""Mean distance between the clouds: how far a point is from the other cloud.

Directed means as in Cignoni, Rocchini and Scopigno, Metro, Computer Graphics Forum 17(2), 1998, between
points rather than surfaces. For a subset the way back is zero, and the mean is that of the originals to their
nearest kept point.
"""

from __future__ import annotations

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "mean_distance_pct": Column("% of diagonal", "Mean distance, the larger of both ways"),
    "mean_distance_backward_pct": Column("% of diagonal", "Mean distance of a reduced point to the original"),
}


def mean_distance(comparison: Comparison) -> dict[str, float]:
    """Mean nearest-neighbour distance, the larger of both ways, and the way back.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    forward = comparison.percent(float(comparison.forward_distances.mean()))
    backward = comparison.percent(float(comparison.backward_distances.mean()))
    return {
        "mean_distance_pct": max(forward, backward),
        "mean_distance_backward_pct": backward,
    }
