"""Clustered vertex sampling by MeshLab: of each grid cell, the point nearest to the cell's centre.

The cell size is searched outside the clock on the grid that MeshLab lays.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._cells import meshlab_cells, n_occupied
from lpcompare_baselines._meshlab import finest_length, length, mesh_set

TRAITS = Traits(
    family="voxel",
    wraps="pymeshlab generate_sampling_clustered_vertex (closest to center)",
    source="Rossignac and Borrel, Multi-resolution 3D approximations for rendering complex scenes, 1993",
    licence="GPL-3.0",
    exact_count=False,
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Cell size, in model units, with the number of occupied cells nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """
    middle, finest = about_center(points), finest_length(points)

    def count(cell_size: float) -> int:
        return n_occupied(meshlab_cells(middle, cell_size))

    return {"cell_size": search_spacing(count, points, target_count, finest=finest, smallest=finest)}


def clustered_vertex(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Keep the most central point of each occupied cell.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cell_size : float
        Edge of a cell in model units; `calibrate` finds it.

    Returns
    -------
    Simplification
        A subset of the input, as many points as cells are occupied.
    """
    meshes = mesh_set(points)
    meshes.generate_sampling_clustered_vertex(
        threshold=length(cell_size, points), sampling="Closest to center"
    )
    # the new layer carries no row numbers, but the filter selects the rows that it took on the first one
    indices = np.flatnonzero(meshes.mesh(0).vertex_selection_array())
    return Simplification(points[indices], indices)
