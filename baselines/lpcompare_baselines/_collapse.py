"""MeshLab's quadric edge collapse, at the face count that leaves the points asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import PointCloud, Points
from lpcompare_baselines._faces import faces_of, search_n_faces
from lpcompare_baselines._meshlab import mesh_set


def search_faces(points: Points, target_count: int, cloud: PointCloud | None, *, optimal: bool) -> int:
    """Number of faces that leaves ``target_count`` points; raises as `collapse` does."""
    faces = faces_of(cloud, target_count)

    def count(n_faces: int) -> int:
        return len(_collapsed(points, faces, n_faces, optimal))

    return search_n_faces(count, target_count, faces)


def collapse(
    points: Points, target_count: int, cloud: PointCloud | None, n_faces: int, *, optimal: bool
) -> Points:
    """Points left, shape (m, 3), about the bounding box's centre of the input.

    Raises
    ------
    NotApplicable
        The cloud has no faces, or they use fewer points than are asked for.
    InputError
        The points, the count or the faces cannot be worked on.
    """
    faces = faces_of(cloud, target_count)
    return _collapsed(points, faces, n_faces, optimal)


def _collapsed(points: Points, faces: NDArray[np.intp], n_faces: int, optimal: bool) -> Points:
    meshes = mesh_set(points, faces)
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=n_faces, optimalplacement=optimal)
    meshes.meshing_remove_unreferenced_vertices()
    return np.ascontiguousarray(meshes.current_mesh().vertex_matrix())
