"""PCD of the Point Cloud Library (pypcd4): every field in its own type, the header and the encoding."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pypcd4.pypcd4 import Encoding
from pypcd4.pypcd4 import PointCloud as PcdFile

from lpcompare.io.checks import checked_points
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"normals", "colors", "attributes"})

_AXES = ("x", "y", "z")
_NORMALS = ("normal_x", "normal_y", "normal_z")
_PADDING = "#"
_LARGEST_COUNT = 9999


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
    plain = [c.astype(_plain_type(c.dtype)) for c in columns.values()]
    PcdFile.from_points(plain, tuple(columns), tuple(c.dtype for c in plain)).save(path)


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same header, encoding and values; an image-like cloud becomes a list of points.

    Rows of text are the file's own: pypcd4 would cut their numbers to ten decimals.
    """
    file, head, size = _open(source), _head(source), b"%d" % len(rows)
    counts = {b"WIDTH": size, b"HEIGHT": b"1", b"POINTS": size}
    for i, line in enumerate(head):
        key = _key(line)
        if key in counts:
            head[i] = re.sub(rb"\d\S*", counts[key], line, count=1)
    text = file.metadata.data == Encoding.ASCII
    body = _text_rows(source, head, rows) if text else _binary_rows(file, rows)
    target.write_bytes(b"".join(head) + body)


def _open(path: Path) -> PcdFile:
    """The whole file.

    Raises
    ------
    ValueError
        Another number of points than the header says, or more values a point than anyone stores, for
        which pypcd4 would take all memory.
    """
    for line in _head(path):
        if _key(line) == b"COUNT" and any(int(value) > _LARGEST_COUNT for value in line.split()[1:]):
            raise ValueError(f"a field has more than {_LARGEST_COUNT} values a point")
    file = PcdFile.from_path(path)
    file.pc_data = np.atleast_1d(file.pc_data)
    promised = max(file.metadata.points, file.metadata.width * file.metadata.height)
    if len(file.pc_data) != promised:
        raise ValueError(f"it promises {promised} points and holds {len(file.pc_data)}")
    return file


def _head(path: Path) -> list[bytes]:
    """Lines of the header with its comments, without the last one, which names the encoding."""
    lines: list[bytes] = []
    with path.open("rb") as file:
        for line in file:
            if line.strip().startswith(b"DATA"):
                return lines
            lines.append(line)
    raise ValueError("its header has no line DATA")


def _key(line: bytes) -> bytes:
    """What a line of the header is about."""
    return line.strip().partition(b" ")[0].upper()


def _text_rows(path: Path, head: list[bytes], rows: Indices) -> bytes:
    """The line of the encoding and those of some points."""
    with path.open("rb") as file:
        encoding, *lines = list(file)[len(head) :]
    points = [line for line in lines if line.partition(b"#")[0].strip()]
    return encoding + b"".join(points[i] for i in rows)


def _binary_rows(file: PcdFile, rows: Indices) -> bytes:
    """The line of the encoding and some points; what cannot be made smaller pypcd4 leaves uncompressed."""
    out = BytesIO()
    PcdFile(file.metadata.derive(points=len(rows)), file.pc_data[rows]).save(out, file.metadata.data)
    return b"DATA " + out.getvalue().partition(b"\nDATA ")[2]


def _plain_type(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """The type of PCD that holds the values: this machine's byte order, no booleans, no half precision."""
    if dtype.kind == "b":
        return np.dtype(np.uint8)
    return np.dtype(np.float32) if dtype == np.float16 else dtype.newbyteorder("=")


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
