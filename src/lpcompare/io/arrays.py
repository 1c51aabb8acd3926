"""NumPy files: .npy with points, .npz with points and one array per attribute."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lpcompare.io.checks import checked_points
from lpcompare.io.polygons import checked_triangles
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"normals", "colors", "attributes", "faces"})

_ARRAY, _ARCHIVE = b"\x93NUMPY", b"PK"
_FIELDS = ("points", "normals", "colors", "faces")


def read(path: Path) -> PointCloud:
    """An array (n, 3) of an .npy, further columns as ``columns``; the arrays of an .npz by their names."""
    with path.open("rb") as file:
        if not file.read(len(_ARRAY)).startswith((_ARRAY, _ARCHIVE)):
            raise ValueError("it begins neither as an array of NumPy nor as a zip of them")
        file.seek(0)
        content = np.load(file, allow_pickle=False)
        if not isinstance(content, np.lib.npyio.NpzFile):
            return _from_array(content, path)
        return _from_archive({name: content[name] for name in content.files}, path)


def write(path: Path, cloud: PointCloud) -> None:
    """An .npy of the coordinates alone, or an .npz of everything."""
    with path.open("wb") as file:
        if path.suffix.lower() == ".npy":
            extra = [v.reshape(len(cloud), -1) for k, v in cloud.attributes.items() if k == "columns"]
            np.save(file, np.column_stack([cloud.points, *extra]))
        else:
            known = {name: getattr(cloud, name) for name in _FIELDS if getattr(cloud, name) is not None}
            np.savez_compressed(file, allow_pickle=False, **known, **cloud.attributes)


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same arrays, in their own types, with some of their rows; arrays of another length stay whole."""
    with source.open("rb") as file, target.open("wb") as out:
        content = np.load(file, allow_pickle=False)
        if not isinstance(content, np.lib.npyio.NpzFile):
            np.save(out, content[rows])
            return
        arrays = {name: content[name] for name in content.files if name != "faces"}
        n_points = len(arrays["points"])
        per_point = {k: v[rows] if v.ndim and len(v) == n_points else v for k, v in arrays.items()}
        np.savez_compressed(out, allow_pickle=False, **per_point)


def _from_array(array: np.ndarray, path: Path) -> PointCloud:
    if array.ndim != 2 or array.shape[1] <= 3:
        return PointCloud(checked_points(array, path.name), name=path.stem)
    points = checked_points(array[:, :3], path.name)
    return PointCloud(points, attributes={"columns": array[:, 3:]}, name=path.stem)


def _from_archive(arrays: dict[str, np.ndarray], path: Path) -> PointCloud:
    if "points" not in arrays:
        raise ValueError(f"it has no array 'points', only {', '.join(sorted(arrays)) or 'nothing'}")
    points = checked_points(arrays["points"], path.name)
    faces = arrays.get("faces")
    if faces is not None:
        faces = checked_triangles(faces.reshape(-1, 3).astype(np.intp), len(points), path.name)
    others = {k: v for k, v in arrays.items() if k not in _FIELDS and v.ndim and len(v) == len(points)}
    return PointCloud(
        points,
        normals=_rows_of(arrays.get("normals"), len(points), 3),
        colors=_rows_of(arrays.get("colors"), len(points), 4),
        attributes=others,
        faces=faces,
        name=path.stem,
    )


def _rows_of(array: np.ndarray | None, n_points: int, width: int) -> np.ndarray | None:
    if array is None:
        return None
    if array.shape != (n_points, width):
        raise ValueError(f"an array has shape {array.shape} where {(n_points, width)} is needed")
    return array.astype(np.float64)
