"""D2, the point-to-plane distortion of MPEG's point cloud coding, by the convention of its tool pc_error.

Tian, Ochimizu, Feng, Cohen and Vetro, Geometric distortion metrics for point cloud compression, ICIP 2017.
The vector from a point to its nearest neighbour in the other cloud is projected on that neighbour's normal;
the mean square is taken each way, and the larger one counts. The originals' normals come from their 10
nearest neighbours; a reduced point has the mean of the normals of the originals nearest to it, or, where
there are none, the normal of the original nearest to it. The tool averages signed normals: here they are
turned alike first, because estimated ones have no sign. The peak is that of D1.
"""

from __future__ import annotations

from math import inf, log10, nan

import numpy as np
from numpy.typing import NDArray

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column, Points

COLUMNS = {
    "d2_mse": Column("square model units", "D2: mean square point-to-plane distance"),
    "d2_psnr_db": Column("dB", "D2 PSNR, the diagonal as the peak", better="higher", alias="d2_mse"),
}


def mpeg_d2(comparison: Comparison) -> dict[str, float]:
    """Symmetric point-to-plane mean square error and its PSNR.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``; the PSNR is infinite where the error is zero, and not a number for
        a cloud without extent.
    """
    original, reduced = comparison.original, comparison.simplified
    normals = comparison.original_normals
    forward, backward = comparison.forward_nearest, comparison.backward_nearest
    mse = max(
        _mean_square(original - reduced[forward], _reduced_normals(normals, forward, backward)[forward]),
        _mean_square(reduced - original[backward], normals[backward]),
    )
    return {"d2_mse": mse, "d2_psnr_db": _psnr(comparison.diagonal, mse)}


def _mean_square(offsets: Points, normals: Points) -> float:
    return float(np.square(np.einsum("qi,qi->q", offsets, normals)).mean())


def _reduced_normals(normals: Points, forward: NDArray[np.intp], backward: NDArray[np.intp]) -> Points:
    """Mean normal of the originals nearest to each reduced point, shape (m, 3)."""
    reference = normals[backward]
    turned = normals * np.where(np.einsum("qi,qi->q", normals, reference[forward]) < 0, -1.0, 1.0)[:, None]
    m = len(backward)
    n_nearest = np.bincount(forward, minlength=m)
    sums = np.column_stack([np.bincount(forward, weights=axis, minlength=m) for axis in turned.T])
    means = sums / np.maximum(n_nearest, 1)[:, None]
    return np.where(n_nearest[:, None] > 0, means, reference)


def _psnr(diagonal: float, mse: float) -> float:
    if diagonal == 0:
        return nan
    return 10 * log10(diagonal**2 / mse) if mse > 0 else inf
