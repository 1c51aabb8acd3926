"""Open3D's voxel grid: of each occupied cube, the mean of its points.

The cube's edge is searched outside the clock.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._open3d import point_cloud, points_of

TRAITS = Traits(
    family="voxel",
    wraps="open3d PointCloud.voxel_down_sample",
    source="Zhou, Park and Koltun, Open3D: A modern library for 3D data processing, 2018",
    licence="MIT",
    moves_points=True,
    keeps_attributes=False,
    exact_count=False,
    requires=("open3d",),
    extra="open3d",
)

_FINEST = 1e-6
"""Share of the diagonal: Open3D refuses cubes whose numbers leave 32 bits."""


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Edge of a cube, in model units, that gives about ``target_count`` points; raises as the method does."""
    cloud, smallest = point_cloud(points), _FINEST * (bounding_box_diagonal(points) or 1.0)

    def count(size: float) -> int:
        return len(cloud.voxel_down_sample(size).points)

    return {"cell_size": search_spacing(count, points, target_count, smallest=smallest)}


def open3d_voxel(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Replace the points of each occupied cube by their mean.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cell_size : float
        Edge of a cube in model units; `calibrate` finds it.

    Returns
    -------
    Simplification
        New points, as many as cubes are occupied.
    """
    kept = points_of(point_cloud(points).voxel_down_sample(cell_size))
    return Simplification(kept + bounding_box_center(points))
