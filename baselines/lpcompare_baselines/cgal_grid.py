"""CGAL's grid simplification: one arbitrary point of each cell of a grid.

The cell size is searched outside the clock. The call includes filling CGAL's point set from Python.
"""

from __future__ import annotations

import numpy as np
from CGAL.CGAL_Point_set_processing_3 import grid_simplify_point_set  # pyright: ignore[reportMissingImports]

from lpcompare.types import Indices, Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._cgal import MOST_CALLS, point_set, rows_of

TRAITS = Traits(
    family="voxel",
    wraps="CGAL grid_simplify_point_set",
    source="CGAL Point Set Processing; Rossignac and Borrel, Multi-resolution 3D approximations, 1993",
    licence="GPL-3.0",
    exact_count=False,
    requires=("CGAL",),
    extra="cgal",
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Cell size, in model units, that gives about ``target_count`` points; raises as the method does."""

    def count(size: float) -> int:
        return len(_grid(points, size))

    return {"cell_size": search_spacing(count, points, target_count, max_calls=MOST_CALLS)}


def cgal_grid(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Keep one point of each occupied cell.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cell_size : float
        Edge of a cell in model units; `calibrate` finds it.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    indices = _grid(points, cell_size)
    return Simplification(points[indices], indices)


def _grid(points: Points, cell_size: float) -> Indices:
    cloud = point_set(points)
    grid_simplify_point_set(cloud, cell_size)
    return rows_of(cloud)
