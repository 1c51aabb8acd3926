"""Objects of other libraries: how `simplify` reads one, and how its result becomes one again.

No library is imported here: an object that is given belongs to a library that is already loaded, and its class is
known by name. One more library is one more `Kind`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from lpcompare.checks import check_cloud, check_coordinates
from lpcompare.types import PointCloud, Simplification


class Kind(NamedTuple):
    """One class of another library.

    Attributes
    ----------
    read : callable
        The points of an object, and its triangles and normals where it has them, as a `PointCloud`.
    take : callable
        The object of the kept rows, shape (m,), with everything that it says of each point.
    make : callable
        An object of new points, shape (m, 3); the given object says the class and the precision.
    """

    read: Callable[[Any], PointCloud]
    take: Callable[[Any, np.ndarray], Any]
    make: Callable[[Any, np.ndarray], Any]


def read_object(given: Any, where: str = "points") -> PointCloud:
    """Any object that `simplify` accepts, as a cloud; what is no known class is taken for an array (n, 3).

    Raises
    ------
    InputError
        It is no such array, or a part of a cloud has not a row for each point.
    """
    kind = _kind(given)
    return kind.read(given) if kind else PointCloud(check_coordinates(given, where))


def make_object(given: Any, result: Simplification) -> Any:
    """The result as an object of the class that was given; the points where that was an array."""
    kind = _kind(given)
    if kind is None:
        return result.points
    return kind.make(given, result.points) if result.indices is None else kind.take(given, result.indices)


def _kind(given: Any) -> Kind | None:
    names = (f"{c.__module__}.{c.__qualname__}" for c in type(given).__mro__)
    return next(
        (kind for name in names if (kind := _KINDS.get(name.replace(".cpu", "").replace(".cuda", "")))), None
    )


def _tensor(given: Any, values: np.ndarray, **types: Any) -> Any:
    positions = given.point.positions
    return type(positions)(values, device=positions.device, **types)


def _read_polydata(given: Any) -> PointCloud:
    faces = given.regular_faces if given.n_cells and given.is_all_triangles else None
    return PointCloud(np.asarray(given.points), faces=None if faces is None else faces.astype(np.intp))


def _take_polydata(given: Any, rows: np.ndarray) -> Any:
    taken = type(given)(np.asarray(given.points)[rows])
    for name, values in given.point_data.items():
        taken.point_data[name] = np.asarray(values)[rows]
    return taken


def _take_trimesh(given: Any, rows: np.ndarray) -> Any:
    colors = given.colors[rows] if len(given.colors) else None
    return type(given)(np.asarray(given.vertices)[rows], colors=colors, metadata=given.metadata)


def _read_meshlab(given: Any) -> PointCloud:
    faces = given.face_matrix().astype(np.intp)
    return PointCloud(given.vertex_matrix(), faces=faces if len(faces) else None)


def _take_meshlab(given: Any, rows: np.ndarray) -> Any:
    return type(given)(
        vertex_matrix=given.vertex_matrix()[rows],
        v_normals_matrix=given.vertex_normal_matrix()[rows],
        v_color_matrix=given.vertex_color_matrix()[rows],
        v_scalar_array=given.vertex_scalar_array()[rows],
    )


_KINDS = {
    "lpcompare.types.PointCloud": Kind(
        read=check_cloud,
        take=lambda given, rows: given.take(rows),
        make=lambda given, points: PointCloud(points, name=given.name),
    ),
    "open3d.pybind.t.geometry.PointCloud": Kind(
        read=lambda given: PointCloud(given.point.positions.cpu().numpy()),
        take=lambda given, rows: given.select_by_index(_tensor(given, rows)),
        make=lambda given, points: type(given)(_tensor(given, points, dtype=given.point.positions.dtype)),
    ),
    "open3d.pybind.geometry.PointCloud": Kind(
        read=lambda given: PointCloud(np.asarray(given.points)),
        take=lambda given, rows: given.select_by_index(rows.tolist()),
        make=lambda given, points: type(given)(type(given.points)(points)),
    ),
    "pyvista.core.pointset.PolyData": Kind(
        read=_read_polydata,
        take=_take_polydata,
        make=lambda given, points: type(given)(points.astype(np.asarray(given.points).dtype)),
    ),
    "trimesh.points.PointCloud": Kind(
        read=lambda given: PointCloud(np.asarray(given.vertices)),
        take=_take_trimesh,
        make=lambda given, points: type(given)(points),
    ),
    "pymeshlab.pmeshlab.Mesh": Kind(
        read=_read_meshlab,
        take=_take_meshlab,
        make=lambda given, points: type(given)(vertex_matrix=points),
    ),
}
