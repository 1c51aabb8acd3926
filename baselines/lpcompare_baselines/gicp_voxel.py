"""small_gicp's voxel grid: of each occupied cube, the mean of its points.

The cube's edge is searched outside the clock; one thread, because the library's count depends on them.
"""

from __future__ import annotations

import numpy as np
import small_gicp

from lpcompare.geometry.scale import about_center, bounding_box_center, bounding_box_diagonal
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing

TRAITS = Traits(
    family="voxel",
    wraps="small_gicp.voxelgrid_sampling",
    source="Koide, small_gicp: Efficient and parallel algorithms for point cloud registration, JOSS 9, 2024",
    licence="MIT",
    moves_points=True,
    keeps_attributes=False,
    exact_count=False,
    requires=("small_gicp",),
    extra="gicp",
)

_FINEST = 1e-6
"""Share of the diagonal: the library drops points whose cube's number needs more than 21 bits."""


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Edge of a cube, in model units, that gives about ``target_count`` points; raises as the method does."""
    smallest = _FINEST * (bounding_box_diagonal(points) or 1.0)

    def count(cell_size: float) -> int:
        return len(_means(points, cell_size))

    return {"cell_size": search_spacing(count, points, target_count, smallest=smallest)}


def gicp_voxel(
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
    return Simplification(_means(points, cell_size) + bounding_box_center(points))


def _means(points: Points, cell_size: float) -> Points:
    """Means of the cubes, about the centre of the bounding box."""
    centred = about_center(points)
    return np.array(small_gicp.voxelgrid_sampling(centred, cell_size, num_threads=1).points())[:, :3]
