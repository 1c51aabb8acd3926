"""MeshLab's layers, and the rows of the input that a filter kept."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError
from lpcompare.geometry.scale import about_center, bounding_box_diagonal
from lpcompare.mesh_library import pymeshlab
from lpcompare.types import Indices, Points

ml = pymeshlab()

_FINEST = 1e-6
"""Share of the bounding box's diagonal."""


def mesh_set(points: Points, faces: NDArray[np.intp] | None = None) -> Any:
    """A MeshSet of one layer: the points about their box's center, each with its row number as its scalar."""
    extra = {} if faces is None else {"face_matrix": faces}
    rows = np.arange(len(points), dtype=float)
    meshes = ml.MeshSet()
    meshes.add_mesh(ml.Mesh(about_center(points), v_scalar_array=rows, **extra))
    return meshes


def rows_of(meshes: Any) -> Indices:
    """Rows of the input that the current layer holds, ascending; the scalar carries them through a filter."""
    return np.sort(meshes.current_mesh().vertex_scalar_array().astype(np.intp))


def collapse(points: Points, faces: NDArray[np.intp], n_faces: int, *, optimal: bool) -> Points:
    """Points left by a quadric edge collapse, shape (m, 3), about the bounding box's centre of the input."""
    meshes = mesh_set(points, faces)
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=n_faces, optimalplacement=optimal)
    meshes.meshing_remove_unreferenced_vertices()
    return np.ascontiguousarray(meshes.current_mesh().vertex_matrix())


def finest_length(points: Points) -> float:
    """The smallest radius or cell size that filters are given: on much smaller ones they run for ever."""
    return _FINEST * (bounding_box_diagonal(points) or 1.0)


def length(value: float, points: Points) -> Any:
    """A radius or cell size as MeshLab takes it, in model units.

    Raises
    ------
    InputError
        The length is not finite or too small for the cloud.
    """
    finest = finest_length(points)
    if not 0.99 * finest <= value < np.inf:
        raise InputError(
            f"A radius or cell size is {value}; on this cloud it must be finite and at least {finest:.3g}."
        )
    return ml.PureValue(value)
