"""Quadric edge collapse by MeshLab onto one end of each edge: a subset of the mesh's points.

Garland and Heckbert's error quadrics on a mesh, without optimal placement. The face count that leaves the
points asked for is searched outside the clock. Points that no face uses are lost.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import about_center
from lpcompare.types import PointCloud, Points, Simplification, Traits
from lpcompare_baselines._faces import faces_of, rows_at, search_n_faces
from lpcompare_baselines._meshlab import collapse

TRAITS = Traits(
    family="mesh",
    wraps="pymeshlab meshing_decimation_quadric_edge_collapse (optimalplacement=False)",
    source="Garland and Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997",
    licence="GPL-3.0",
    needs_mesh=True,
)


def calibrate(
    points: Points, target_count: int, *, rng: np.random.Generator, cloud: PointCloud | None = None
) -> dict[str, int]:
    """Number of faces that leaves ``target_count`` points; raises as the method does."""
    faces = faces_of(cloud, target_count)

    def count(n_faces: int) -> int:
        return len(collapse(points, faces, n_faces, optimal=False))

    return {"n_faces": search_n_faces(count, target_count, faces)}


def quadric_collapse_subset(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    cloud: PointCloud | None = None,
    n_faces: int,
) -> Simplification:
    """Collapse each edge onto one of its ends, the least quadric error first.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of points that faces use.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cloud : PointCloud
        The same points with their faces.
    n_faces : int
        Faces to keep; `calibrate` finds it.

    Returns
    -------
    Simplification
        A subset of the input; MeshLab names no rows, so they are found by their positions.

    Raises
    ------
    NotApplicable
        The cloud has no faces, or they use fewer points than are asked for.
    """
    kept = collapse(points, faces_of(cloud, target_count), n_faces, optimal=False)
    indices = rows_at(about_center(points), kept)
    return Simplification(points[indices], indices)
