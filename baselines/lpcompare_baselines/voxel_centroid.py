"""Voxel grid: of each occupied cube, the mean of its points (numpy).

The cube's edge is searched outside the clock so that as many cubes are occupied as points are wanted.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._cells import cell_means, finest_cell, grid_cells, n_occupied

TRAITS = Traits(
    family="voxel",
    wraps="numpy",
    source="Rusu and Cousins, 3D is here: Point Cloud Library, ICRA 2011 (VoxelGrid)",
    licence="BSD-3-Clause",
    moves_points=True,
    keeps_attributes=False,
    exact_count=False,
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Edge, in model units, with the number of occupied cubes nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """

    def count(cell_size: float) -> int:
        return n_occupied(grid_cells(points, cell_size))

    return {"cell_size": search_spacing(count, points, target_count, finest=finest_cell(points))}


def voxel_centroid(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Replace the points of each occupied cube by their mean.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cell_size : float
        Edge of a cube in model units; `calibrate` finds it.

    Returns
    -------
    Simplification
        New points, as many as cubes are occupied.
    """
    center = bounding_box_center(points)
    means, _ = cell_means(points - center, grid_cells(points, cell_size))
    return Simplification(means + center)
