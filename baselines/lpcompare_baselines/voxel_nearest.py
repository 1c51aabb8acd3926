"""Voxel grid: of each occupied cube, the point nearest to the mean of the cube's points (numpy).

The cube's edge is searched outside the clock so that as many cubes are occupied as points are wanted.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._cells import cell_means, finest_cell, grid_cells, n_occupied
from lpcompare_baselines._clusters import nearest_members

TRAITS = Traits(
    family="voxel",
    wraps="numpy",
    source="Rusu and Cousins, 3D is here: Point Cloud Library, ICRA 2011 (VoxelGrid)",
    licence="BSD-3-Clause",
    exact_count=False,
    in_tiles=True,
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


def voxel_nearest(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Keep one point of each occupied cube.

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
        A subset of the input, as many points as cubes are occupied.
    """
    means, group = cell_means(points, grid_cells(points, cell_size))
    indices = nearest_members(points, group, means)
    return Simplification(points[indices], indices)
