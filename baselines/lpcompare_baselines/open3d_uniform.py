"""Open3D's uniform down sampling: every k-th point in the order of the file.

Only the counts n / k can be had, and what is kept depends on how the file is ordered.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._faces import rows_at
from lpcompare_baselines._open3d import point_cloud, points_of

TRAITS = Traits(
    family="random",
    wraps="open3d PointCloud.uniform_down_sample",
    source="Zhou, Park and Koltun, Open3D: A modern library for 3D data processing, 2018",
    licence="MIT",
    exact_count=False,
    requires=("open3d",),
    extra="open3d",
)


def open3d_uniform(
    points: Points, target_count: int, *, rng: np.random.Generator, every: int | None = None
) -> Simplification:
    """Keep every k-th row.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    every : int, optional
        The step k; by default the one whose count is nearest to ``target_count``.

    Returns
    -------
    Simplification
        A subset of the input; Open3D names no rows, so they are found by their positions.
    """
    n = len(points)
    if every is None:
        low = max(n // target_count, 1)
        every = min(low, low + 1, key=lambda k: abs(-(-n // k) - target_count))
    kept = points_of(point_cloud(points).uniform_down_sample(every))
    indices = rows_at(about_center(points), kept)
    return Simplification(points[indices], indices)
