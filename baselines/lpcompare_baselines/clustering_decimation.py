"""Clustering decimation by MeshLab: each grid cell's points become their mean.

A regular grid is laid over the cloud and every occupied cell becomes one point; the cell size is searched
outside the clock. Faces are not used, so that the method stands with those on points alone: with them MeshLab
weighs the points by their faces.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center, bounding_box_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._cells import meshlab_cells, n_occupied
from lpcompare_baselines._meshlab import finest_length, length, mesh_set

TRAITS = Traits(
    family="voxel",
    wraps="pymeshlab meshing_decimation_clustering",
    source="Rossignac and Borrel, Multi-resolution 3D approximations for rendering complex scenes, 1993",
    licence="GPL-3.0",
    moves_points=True,
    keeps_attributes=False,
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


def clustering_decimation(
    points: Points, target_count: int, *, rng: np.random.Generator, cell_size: float
) -> Simplification:
    """Replace the points of each cell by their mean.

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
        New points, as many as cells are occupied.
    """
    meshes = mesh_set(points)
    meshes.meshing_decimation_clustering(threshold=length(cell_size, points))
    return Simplification(meshes.current_mesh().vertex_matrix() + bounding_box_center(points))
