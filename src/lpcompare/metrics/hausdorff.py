"""Hausdorff distance between the clouds: how far a point can be from the other cloud.

Directed distances as in Cignoni, Rocchini and Scopigno, Metro, Computer Graphics Forum 17(2), 1998, between
points rather than surfaces. For a subset the way back is zero, and the distance is the covering radius of the
k-centre problem (Gonzalez, Clustering to minimize the maximum intercluster distance, Theoretical Computer
Science 38, 1985), which farthest point sampling keeps within twice its least value.
"""

from __future__ import annotations

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "hausdorff_pct": Column("% of diagonal", "Hausdorff distance, the larger of both ways"),
    "hausdorff_backward_pct": Column("% of diagonal", "Largest distance of a reduced point to the original"),
}


def hausdorff(comparison: Comparison) -> dict[str, float]:
    """Largest nearest-neighbour distance, the larger of both ways, and the way back.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    forward = comparison.percent(float(comparison.forward_distances.max()))
    backward = comparison.percent(float(comparison.backward_distances.max()))
    return {
        "hausdorff_pct": max(forward, backward),
        "hausdorff_backward_pct": backward,
    }
