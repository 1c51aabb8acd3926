"""VTK's voxel grid: the mean of the points of each occupied cube.

The edge of the cubes is searched outside the clock.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._vtk import finest_length, voxel_means

TRAITS = Traits(
    wraps="vtk vtkVoxelGrid",
    source="Schroeder, Martin and Lorensen, The Visualization Toolkit, 4th edition, 2006",
    licence="BSD-3-Clause",
    family="voxel",
    moves_points=True,
    keeps_attributes=False,
    exact_count=False,
    requires=("vtkmodules",),
    extra="vtk",
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Edge, in model units, with the number of occupied cubes nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """
    finest = finest_length(points)

    def count(cell_size: float) -> int:
        return len(voxel_means(points, cell_size))

    return {"cell_size": search_spacing(count, points, target_count, finest=finest, smallest=finest)}


def vtk_voxel_grid(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Keep one mean per occupied cube.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cell_size : float
        Edge of a cube in model units.

    Returns
    -------
    Simplification
        New points, as many as cubes are occupied.
    """
    return Simplification(voxel_means(points, cell_size))
