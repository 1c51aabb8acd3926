"""PLY, ascii and binary (plyfile): every property, comment and object-information line is kept."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plyfile import PlyData, PlyElement, PlyElementParseError, PlyListProperty

from lpcompare.io.checks import checked_points
from lpcompare.io.polygons import fan_triangles, strip_triangles
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"normals", "colors", "attributes", "faces"})

_AXES = ("x", "y", "z")
_NORMALS = ("nx", "ny", "nz")
_COLORS = ("red", "green", "blue")
_CORNERS = ("vertex_indices", "vertex_index")


def read(path: Path) -> PointCloud:
    """The vertices with their scalar properties; faces and triangle strips as triangles."""
    file = _open(path)
    vertices = _vertices(file)
    points = checked_points(_columns(vertices.data, _AXES), path.name)
    scalars = {p.name for p in vertices.properties if not isinstance(p, PlyListProperty)}
    normals = _columns(vertices.data, _NORMALS) if scalars.issuperset(_NORMALS) else None
    colors = _colors(vertices.data, scalars) if scalars.issuperset(_COLORS) else None
    known = {*_AXES} | ({*_NORMALS} if normals is not None else set())
    known |= {*_COLORS, "alpha"} if colors is not None else set()
    attributes = {n: np.array(vertices[n]) for n in vertices.data.dtype.names or () if n in scalars - known}
    return PointCloud(points, normals, colors, attributes, _faces(file, len(points), path.name), path.stem)


def write(path: Path, cloud: PointCloud) -> None:
    """Binary PLY: coordinates as doubles, colours as bytes, attributes in their own types, triangles."""
    elements = [PlyElement.describe(_structured(cloud), "vertex")]
    if cloud.faces is not None:
        faces = np.empty(len(cloud.faces), dtype=[("vertex_indices", "i4", (3,))])
        faces["vertex_indices"] = cloud.faces
        elements.append(PlyElement.describe(faces, "face"))
    PlyData(elements, byte_order="<").write(str(path))


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same file with some of its vertices; elements that name vertices, such as faces, are left out."""
    file = _open(source)
    kept = []
    for element in file.elements:
        if element.name == "vertex":
            vertices = PlyElement("vertex", tuple(element.properties), len(rows), element.comments)
            vertices.data = np.array(element.data[rows])
            kept.append(vertices)
        elif not any(p.name.startswith("vertex") for p in element.properties):
            kept.append(element)
    PlyData(kept, file.text, file.byte_order, file.comments, file.obj_info).write(str(target))


def _open(path: Path) -> PlyData:
    """The file's elements; lists of three corners, the usual case, are read at once and not one by one."""
    _check_counts(path)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "loadtxt: input contained no data")  # an empty list in ascii
        try:
            return PlyData.read(str(path), known_list_len={"face": dict.fromkeys(_CORNERS, 3)})
        except PlyElementParseError:
            return PlyData.read(str(path))


def _check_counts(path: Path) -> None:
    """Raise a `ValueError` where the file has fewer bytes than values; plyfile makes room for all first."""
    size = path.stat().st_size
    with path.open("rb") as file:
        name, count, n_properties = b"", 0, 0
        for line in file:
            match line.split():
                case [b"element", name, number] if number.isdigit():
                    count, n_properties = int(number), 0
                case [b"property", *_]:
                    n_properties += 1
                case [b"end_header"]:
                    return
            if count * max(n_properties, 1) > size:
                rows = f"{count} rows of {name.decode(errors='replace')!r}"
                raise ValueError(f"it promises {rows} and holds {size} bytes")


def _vertices(file: PlyData) -> PlyElement:
    if "vertex" not in file or not {*_AXES} <= {p.name for p in file["vertex"].properties}:
        raise ValueError("it has no element 'vertex' with properties x, y and z")
    return file["vertex"]


def _columns(data: NDArray[Any], names: tuple[str, ...]) -> NDArray[np.float64]:
    return np.column_stack([data[name] for name in names]).astype(np.float64)


def _colors(data: NDArray[Any], scalars: set[str]) -> NDArray[np.float64]:
    """Red, green, blue, alpha from 0 to 1; integers are scaled by the largest value of their type."""
    names = (*_COLORS, "alpha") if "alpha" in scalars else _COLORS
    channels = [data[n] / (np.iinfo(data[n].dtype).max if data[n].dtype.kind in "iu" else 1.0) for n in names]
    alpha = [] if "alpha" in scalars else [np.ones(len(data))]
    return np.column_stack(channels + alpha).astype(np.float64)


def _faces(file: PlyData, n_points: int, where: str) -> NDArray[np.intp] | None:
    if "tristrips" in file and len(file["tristrips"].data):
        strips = [s for name in _CORNERS if name in file["tristrips"] for s in file["tristrips"][name]]
        return strip_triangles(np.concatenate([np.append(s, -1) for s in strips]), n_points, where)
    if "face" not in file:
        return None
    names = [p.name for p in file["face"].properties if p.name in _CORNERS]
    return fan_triangles(file["face"][names[0]], n_points, where) if names else None


def _structured(cloud: PointCloud) -> NDArray[Any]:
    """The cloud as one row of named scalars per point; a column of an attribute of several is numbered."""
    columns: dict[str, NDArray[Any]] = dict(zip(_AXES, cloud.points.T, strict=True))
    if cloud.normals is not None:
        columns |= dict(zip(_NORMALS, cloud.normals.T, strict=True))
    if cloud.colors is not None:
        bytes_ = np.rint(np.clip(cloud.colors, 0, 1) * 255).astype(np.uint8)
        columns |= dict(zip((*_COLORS, "alpha"), bytes_.T, strict=True))
    for name, values in cloud.attributes.items():
        flat = values.reshape(len(values), -1)
        suffixes = [""] if flat.shape[1] == 1 else [f"_{i}" for i in range(flat.shape[1])]
        columns |= {f"{name}{s}".replace(" ", "_"): c for s, c in zip(suffixes, flat.T, strict=True)}
    table = np.empty(len(cloud), dtype=[(n, _ply_type(c.dtype)) for n, c in columns.items()])
    for name, values in columns.items():
        table[name] = values
    return table


def _ply_type(dtype: np.dtype[Any]) -> str:
    """The PLY type that holds the values; PLY has no integers of 64 bits, so those become doubles."""
    if dtype.kind == "b":
        return "u1"
    return "<f8" if dtype.itemsize > 4 or dtype.kind not in "iuf" or dtype == np.float16 else dtype.str
