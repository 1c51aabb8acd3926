"""PCD of the Point Cloud Library (pypcd4): every field in its own type, the viewpoint and the encoding."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pypcd4.pypcd4 import PointCloud as PcdFile

from lpcompare.io.checks import checked_points
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"normals", "colors", "attributes"})

_AXES = ("x", "y", "z")
_NORMALS = ("normal_x", "normal_y", "normal_z")
_PADDING = "#"


def read(path: Path) -> PointCloud:
    """Coordinates, normals, the packed colour as red, green, blue, alpha; every other field as it is."""
    table = _open(path).pc_data
    names = [name for name in table.dtype.names or () if not name.startswith(_PADDING)]
    if not {*_AXES} <= set(names):
        raise ValueError("it has no fields x, y and z")
    points = checked_points(np.column_stack([table[n] for n in _AXES]), path.name)
    packed = next((n for n in ("rgba", "rgb") if n in names and table[n].dtype.itemsize == 4), "")
    normals = None
    if {*_NORMALS} <= set(names):
        normals = np.column_stack([table[n] for n in _NORMALS]).astype(np.float64)
    known = {*_AXES, packed} | ({*_NORMALS} if normals is not None else set())
    return PointCloud(
        points,
        normals=normals,
        colors=_unpacked(table[packed], packed == "rgba") if packed else None,
        attributes={n: np.array(table[n]) for n in names if n not in known},
        name=path.stem,
    )


def write(path: Path, cloud: PointCloud) -> None:
    """Binary PCD; coordinates in single precision where that loses nothing, as PCL expects them."""
    exact = np.array_equal(cloud.points.astype(np.float32), cloud.points)
    columns: dict[str, NDArray[Any]] = dict(
        zip(_AXES, cloud.points.T.astype(np.float32 if exact else np.float64), strict=True)
    )
    if cloud.normals is not None:
        columns |= dict(zip(_NORMALS, cloud.normals.T.astype(np.float32), strict=True))
    if cloud.colors is not None:
        columns["rgba"] = _packed(cloud.colors)
    for name, values in cloud.attributes.items():
        flat = values.reshape(len(cloud), -1)
        suffixes = [""] if flat.shape[1] == 1 else [f"_{i}" for i in range(flat.shape[1])]
        columns |= {f"{name}{s}".replace(" ", "_"): c for s, c in zip(suffixes, flat.T, strict=True)}
    plain = [c.astype(np.uint8) if c.dtype.kind == "b" else c for c in columns.values()]
    PcdFile.from_points(plain, tuple(columns), tuple(c.dtype for c in plain)).save(path)


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same fields, viewpoint and encoding; an image-like cloud becomes a list of points."""
    file = _open(source)
    header = file.metadata.derive(points=len(rows), width=len(rows), height=1)
    PcdFile(header, np.atleast_1d(file.pc_data)[rows]).save(target, encoding=header.data)


def _open(path: Path) -> PcdFile:
    """The whole file; another number of points than the header says is a `ValueError`."""
    file = PcdFile.from_path(path)
    file.pc_data = np.atleast_1d(file.pc_data)
    promised = max(file.metadata.points, file.metadata.width * file.metadata.height)
    if len(file.pc_data) != promised:
        raise ValueError(f"it promises {promised} points and holds {len(file.pc_data)}")
    return file


def _unpacked(packed: NDArray[Any], with_alpha: bool) -> NDArray[np.float64]:
    """Bytes alpha, red, green, blue of one word of 32 bits, as fractions."""
    words = np.ascontiguousarray(packed).view(np.uint32)
    channels = np.column_stack([words >> shift & 255 for shift in (16, 8, 0, 24)]) / 255.0
    if not with_alpha:
        channels[:, 3] = 1.0
    return channels


def _packed(colors: NDArray[np.float64]) -> NDArray[np.uint32]:
    red, green, blue, alpha = np.rint(np.clip(colors, 0, 1) * 255).astype(np.uint32).T
    return alpha << 24 | red << 16 | green << 8 | blue
