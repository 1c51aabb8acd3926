"""Voxel grid: of each occupied cube, the point nearest to the mean of the cube's points (numpy).

The cube's edge is searched outside the clock so that as many cubes are occupied as points are wanted.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_size, surface_spacing
from lpcompare_baselines._cells import cell_means, finest_cell, grid_cells, n_occupied
from lpcompare_baselines._guards import check_distinct, check_resolved

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
    check_distinct(points, target_count)
    check_resolved(points, target_count, finest_cell(points))
    start = surface_spacing(points, target_count)
    return {"cell_size": search_size(lambda c: n_occupied(grid_cells(points, c)), target_count, start)}


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
    squared = np.square(points - means[group]).sum(axis=1)
    order = np.lexsort((squared, group))
    indices = np.sort(order[np.flatnonzero(np.diff(group[order], prepend=-1))])
    return Simplification(points[indices], indices)
