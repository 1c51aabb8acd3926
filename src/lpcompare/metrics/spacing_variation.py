"""Spacing variation: how uneven the distances between neighbouring kept points are.

The coefficient of variation of the nearest-neighbour distances; 0 for a lattice, about 0.5 for points at
random in the plane (Clark and Evans, Ecology 35(4), 1954). An adaptive method is uneven on purpose.
"""

from __future__ import annotations

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {"spacing_variation": Column("", "Deviation of the spacing of kept points, over its mean")}


def spacing_variation(comparison: Comparison) -> dict[str, float]:
    """Standard deviation of the distance to the next kept point, divided by its mean.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``; 0 where all kept points coincide or there is one.
    """
    spacings = comparison.spacings
    mean = float(spacings.mean())
    return {"spacing_variation": float(spacings.std()) / mean if mean > 0 else 0.0}
