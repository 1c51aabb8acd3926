"""MeshLab's filters on clean points only, asked which rows they kept.

What reaches a filter unguarded can hang or kill the process: such input is declined here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError, NotApplicable
from lpcompare.geometry.scale import bounding_box_center
from lpcompare.mesh_library import pymeshlab
from lpcompare.types import Indices, Points

ml = pymeshlab()


def check(points: Points, target_count: int) -> None:
    """Refuse what makes a filter hang, crash or return nonsense.

    Raises
    ------
    InputError
        The cloud is empty or holds NaN or infinity, or the count is not from 1 to n.
    """
    if len(points) == 0 or not np.isfinite(points).all():
        raise InputError("The cloud is empty or has NaN or infinite coordinates; remove those points first.")
    if not 1 <= target_count <= len(points):
        raise InputError(
            f"target_count is {target_count}; it must be from 1 to the {len(points)} points given."
        )


def check_distinct(points: Points, target_count: int) -> None:
    """Decline a count that a filter which drops duplicates cannot return; raises NotApplicable."""
    n_distinct = len(np.unique(points, axis=0))
    if target_count > n_distinct:
        raise NotApplicable(
            f"{target_count} points are asked for, but only {n_distinct} of the {len(points)} are distinct; "
            "ask for fewer."
        )


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
