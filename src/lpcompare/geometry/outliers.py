"""Points that lie alone, by the mean distance to their neighbours."""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Mask, Points

N_NEIGHBORS = 12


def outlier_mask(points: Points, n_deviations: float) -> Mask:
    """The points whose mean distance to their 12 nearest is far above the cloud's mean.

    Statistical outlier removal of Rusu, Marton, Blodow, Dolha and Beetz (Towards 3D point cloud based object
    maps for household environments, 2008, section 3.2), as in PCL, Open3D and CloudCompare.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Finite.
    n_deviations : float
        How many standard deviations above the mean is far.

    Returns
    -------
    ndarray of bool, shape (n,)
        True for outliers; never all of the points.
    """
    n_nearest = min(N_NEIGHBORS, len(points) - 1)
    if n_nearest < 1:
        return np.zeros(len(points), dtype=np.bool_)
    distances, _ = Neighbors(points).query(points, n_nearest + 1)
    means = distances.sum(axis=1) / n_nearest
    return means > means.mean() + n_deviations * means.std()
