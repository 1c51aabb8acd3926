"""Eq. 27: distance of every original to the PCA plane through its nearest reduced points.

Leal, Leal and Sanchez-Torres (2017), "Error measurement". The paper leaves the number of neighbours open;
8 is the default here, and 6 and 12 stand beside it because the ranking of methods can depend on it.
"""

from __future__ import annotations

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "plane_error_pct": Column("% of diagonal", "Eq. 27 error, 8 neighbours"),
    "plane_error_max_pct": Column("% of diagonal", "Largest eq. 27 distance, 8 neighbours"),
    "plane_error": Column(
        "model units", "Eq. 27 error, 8 neighbours, in model units", alias="plane_error_pct"
    ),
    "plane_error_k6_pct": Column("% of diagonal", "Eq. 27 error, 6 neighbours"),
    "plane_error_k12_pct": Column("% of diagonal", "Eq. 27 error, 12 neighbours"),
}


def plane_error(comparison: Comparison) -> dict[str, float]:
    """Mean and largest plane distance (eq. 27).

    Parameters
    ----------
    comparison : Comparison
        The original and the simplified cloud.

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    errors = comparison.plane_errors(8)
    return {
        "plane_error_pct": comparison.plane_error_percent(8),
        "plane_error_max_pct": comparison.percent(float(errors.max())),
        "plane_error": float(errors.mean()),
        "plane_error_k6_pct": comparison.plane_error_percent(6),
        "plane_error_k12_pct": comparison.plane_error_percent(12),
    }
