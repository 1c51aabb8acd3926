"""Layers of a MeshSet as arrays, and back: what MeshLab keeps per vertex follows the vertices that stay."""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.errors import InputError
from lpcompare.mesh_library import pymeshlab
from lpcompare.types import Indices, Points, Vector

ATTRIBUTE_NAMES: set[str] = set()
"""Names of custom attributes that were seen; pymeshlab can answer for a name but lists none."""


def coordinates(mesh: Any) -> Points:
    """Vertices of a layer where its matrix puts them, shape (n, 3).

    Raises
    ------
    InputError
        No vertices, or coordinates that are NaN or infinite.
    """
    if mesh.vertex_number() == 0:
        raise InputError(f"Mesh '{mesh.label()}' has no vertices.")
    points = np.ascontiguousarray(mesh.transformed_vertex_matrix())
    bad = int((~np.isfinite(points).all(axis=1)).sum())
    if bad:
        raise InputError(
            f"{bad} of {len(points)} vertices of mesh '{mesh.label()}' have NaN or infinite coordinates; "
            "remove them first."
        )
    return points


def used_rows(mesh: Any, selected: bool) -> Indices:
    """Rows that a filter works on: the selected vertices, or all.

    Raises
    ------
    InputError
        ``selected`` and nothing is.
    """
    if not selected:
        return np.arange(mesh.vertex_number())
    rows = np.flatnonzero(mesh.vertex_selection_array())
    if not rows.size:
        raise InputError(f"No vertices of mesh '{mesh.label()}' are selected; select some, or all.")
    return rows


def add_subset(layers: Any, source: Any, rows: Indices, label: str) -> None:
    """Add some vertices of a layer as a new, current layer without faces.

    Positions, normals, colours, quality, texture coordinates, custom attributes and the matrix are those of
    the source, which is not touched.
    """
    known = pymeshlab()
    values: dict[str, Any] = {
        "vertex_matrix": source.vertex_matrix()[rows],
        "v_normals_matrix": source.vertex_normal_matrix()[rows],
    }
    if source.has_vertex_color():
        # pymeshlab stores int(255 * x): a quarter of a step keeps every byte what it was
        values["v_color_matrix"] = (np.rint(source.vertex_color_matrix()[rows] * 255) + 0.25) / 255
    if source.has_vertex_scalar():
        values["v_scalar_array"] = source.vertex_scalar_array()[rows]
    if source.has_vertex_tex_coord():
        values["v_tex_coords_matrix"] = source.vertex_tex_coord_matrix()[rows]
    scalars, vectors = custom_attributes(source)
    matrix = source.transform_matrix()
    layers.add_mesh(known.Mesh(**values), label, True)
    # custom attributes must come after add_mesh: those of an added mesh crash MeshLab later
    added = layers.current_mesh()
    for name, column in scalars.items():
        added.add_vertex_custom_scalar_attribute(column[rows], name)
    for name, column in vectors.items():
        added.add_vertex_custom_point_attribute(column[rows], name)
    if not np.array_equal(matrix, np.eye(4)):
        layers.set_matrix(transformmatrix=matrix, freeze=False)


def custom_attributes(mesh: Any) -> tuple[dict[str, Vector], dict[str, Points]]:
    """Custom scalars and points of a layer, as far as their names are known."""
    refusal = pymeshlab().PyMeshLabException
    scalars: dict[str, Vector] = {}
    vectors: dict[str, Points] = {}
    for name in sorted(ATTRIBUTE_NAMES):
        try:
            scalars[name] = mesh.vertex_custom_scalar_attribute_array(name)
        except refusal:
            try:
                vectors[name] = mesh.vertex_custom_point_attribute_matrix(name)
            except refusal:
                continue
    return scalars, vectors


def fill_scalar(layers: Any, mesh_id: int, rows: Indices, values: Vector, name: str) -> None:
    """Put values into the quality of some vertices of a layer, exactly, and keep them as a custom attribute.

    pymeshlab has no way to set the quality from an array; the attribute is the way there, under ``name``
    or the first free name_2, name_3, ...
    """
    current = layers.current_mesh_id()
    layers.set_current_mesh(mesh_id)
    try:
        mesh = layers.current_mesh()
        before = mesh.vertex_scalar_array() if mesh.has_vertex_scalar() else np.zeros(mesh.vertex_number())
        column = before.copy()
        column[rows] = values
        free = _add_attribute(mesh, column, name)
        layers.compute_scalar_by_function_per_vertex(q=free)
    finally:
        layers.set_current_mesh(current)


def _add_attribute(mesh: Any, column: Vector, name: str) -> str:
    scalars, vectors = custom_attributes(mesh)
    free, number = name, 2
    while free in scalars or free in vectors:
        free, number = f"{name}_{number}", number + 1
    mesh.add_vertex_custom_scalar_attribute(column, free)
    ATTRIBUTE_NAMES.add(free)
    return free
