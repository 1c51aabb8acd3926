"""Normal deviation: angle between an original's normal and that of the reduced cloud beside it.

Both normals are those of the plane through the 10 nearest points of their own cloud, so their sign is not
used. Angles to normals are the shape measure of Cohen-Steiner, Alliez and Desbrun, Variational shape
approximation, SIGGRAPH 2004.
"""

from __future__ import annotations

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "normal_deviation_deg": Column("degrees", "Mean angle between the normals of original and reduced cloud")
}


def normal_deviation(comparison: Comparison) -> dict[str, float]:
    """Mean angle, from 0 to 90 degrees, between each original's normal and its nearest reduced point's.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``.
    """
    beside = comparison.simplified_normals[comparison.forward_nearest]
    cross = np.linalg.norm(np.cross(comparison.original_normals, beside), axis=1)
    dot = np.abs(np.einsum("qi,qi->q", comparison.original_normals, beside))
    return {"normal_deviation_deg": float(np.degrees(np.arctan2(cross, dot)).mean())}
