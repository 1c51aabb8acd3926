"""Open3D's farthest point sampling, which compares every point with every kept one.

Its cost is n times m: seconds at 100,000 points, hours at millions.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._faces import rows_at
from lpcompare_baselines._guards import check_distinct
from lpcompare_baselines._open3d import point_cloud, points_of

TRAITS = Traits(
    family="spacing",
    wraps="open3d PointCloud.farthest_point_down_sample",
    source="Eldar, Lindenbaum, Porat and Zeevi, The farthest point strategy for progressive image sampling, "
    "IEEE Transactions on Image Processing 6(9), 1997",
    licence="MIT",
    requires=("open3d",),
    extra="open3d",
)


def open3d_farthest_point(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep the first ``target_count`` points of the farthest-point order.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws the first point.

    Returns
    -------
    Simplification
        A subset of the input; Open3D names no rows, so they are found by their positions.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    check_distinct(points, target_count)
    first = int(rng.integers(len(points)))
    kept = points_of(point_cloud(points).farthest_point_down_sample(target_count, first))
    indices = rows_at(about_center(points), kept)
    return Simplification(points[indices], indices)
