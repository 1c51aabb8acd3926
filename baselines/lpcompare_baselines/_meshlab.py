"""MeshLab's layers, and the rows of the input that a filter kept."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.scale import bounding_box_center
from lpcompare.mesh_library import pymeshlab
from lpcompare.types import Indices, Points

ml = pymeshlab()


def centred(points: Points) -> Points:
    """The points about the centre of their bounding box: MeshLab holds lengths in single precision."""
    return points - bounding_box_center(points)


def mesh_set(points: Points, faces: NDArray[np.intp] | None = None) -> Any:
    """A MeshSet of one layer: the centred points, each with its row number as its scalar."""
    extra = {} if faces is None else {"face_matrix": faces}
    rows = np.arange(len(points), dtype=float)
    meshes = ml.MeshSet()
    meshes.add_mesh(ml.Mesh(centred(points), v_scalar_array=rows, **extra))
    return meshes


def rows_of(meshes: Any) -> Indices:
    """Rows of the input that the current layer holds, ascending; the scalar carries them through a filter."""
    return np.sort(meshes.current_mesh().vertex_scalar_array().astype(np.intp))
