"""D1, the point-to-point distortion of MPEG's point cloud coding, by the convention of its tool pc_error.

Tian, Ochimizu, Feng, Cohen and Vetro, Geometric distortion metrics for point cloud compression, ICIP 2017.
The mean square of the nearest-neighbour distances is taken each way, and the larger one counts. PSNR is
10 log10(3 p^2 / MSE); with the edge p of the coder's cube, 3 p^2 is its squared diagonal, and so the squared
bounding-box diagonal of the original stands here.
"""

from __future__ import annotations

from math import inf, log10, nan

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "d1_mse": Column("square model units", "D1: mean square point-to-point distance"),
    "d1_psnr_db": Column("dB", "D1 PSNR, the diagonal as the peak", better="higher", alias="d1_mse"),
}


def mpeg_d1(comparison: Comparison) -> dict[str, float]:
    """Symmetric point-to-point mean square error and its PSNR.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``; the PSNR of equal clouds is infinite, that of a cloud without
        extent not a number.
    """
    ways = comparison.forward_distances, comparison.backward_distances
    mse = float(max(np.square(d).mean() for d in ways))
    return {"d1_mse": mse, "d1_psnr_db": _psnr(comparison.diagonal, mse)}


def _psnr(diagonal: float, mse: float) -> float:
    if diagonal == 0:
        return nan
    return 10 * log10(diagonal**2 / mse) if mse > 0 else inf
