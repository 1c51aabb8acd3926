"""The other formats that MeshLab reads, through pymeshlab; they cannot be written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from lpcompare.io.checks import checked_points
from lpcompare.io.foreign_length import check_length
from lpcompare.mesh_library import pymeshlab
from lpcompare.types import PointCloud


def read(path: Path) -> PointCloud:
    """All layers of the file as one cloud, each in its place; polygons as triangles.

    Normals are taken from files without faces only: of a mesh, MeshLab computes them anew.
    """
    check_length(path)
    layers = pymeshlab().MeshSet()
    layers.load_new_mesh(str(path.resolve()))
    if layers.mesh_number() > 1:
        layers.generate_by_merging_visible_meshes(mergevertices=False)
    mesh: Any = layers.current_mesh()
    normals = mesh.vertex_normal_matrix() if not mesh.face_number() else np.zeros(0)
    return PointCloud(
        checked_points(mesh.transformed_vertex_matrix(), path.name),
        normals=normals if normals.any() else None,
        colors=mesh.vertex_color_matrix() if mesh.has_vertex_color() else None,
        attributes={"quality": mesh.vertex_scalar_array()} if mesh.has_vertex_scalar() else {},
        faces=mesh.face_matrix().astype(np.intp) if mesh.face_number() else None,
        name=path.stem,
    )
