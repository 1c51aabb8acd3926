"""Poisson disk sampling of the points by point-cloud-utils, which can be seeded.

The same algorithm as MeshLab's, from the same library (vcglib). Its own search for the radius is part of the
call and ends within a tolerance.
"""

from __future__ import annotations

import numpy as np
import point_cloud_utils

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._guards import check_distinct

TRAITS = Traits(
    family="spacing",
    wraps="point_cloud_utils.downsample_point_cloud_poisson_disk",
    source="Corsini, Cignoni and Scopigno, Efficient and flexible sampling with blue noise properties of "
    "triangular meshes, IEEE TVCG 18(6), 2012",
    licence="GPL-3.0",
    exact_count=False,
    requires=("point_cloud_utils",),
    extra="pcu",
)

_LARGEST_SEED = 2**31 - 1


def pcu_poisson_disk(
    points: Points, target_count: int, *, rng: np.random.Generator, tolerance: float = 0.005
) -> Simplification:
    """Keep a set of points that are a radius apart.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws the library's seed.
    tolerance : float, optional
        Share of the count that may be missed.

    Returns
    -------
    Simplification
        A subset of the input, of about ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    check_distinct(points, target_count)
    rows = point_cloud_utils.downsample_point_cloud_poisson_disk(
        about_center(points),
        -1.0,
        target_count,
        int(rng.integers(1, _LARGEST_SEED)),
        tolerance,
    )
    indices = np.unique(np.asarray(rows, dtype=np.intp))
    return Simplification(points[indices], indices)
