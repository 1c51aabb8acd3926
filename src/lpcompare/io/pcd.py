"""PCD of the Point Cloud Library: every field in its own type, the header and the encoding.

Read here and not by a library, because other tools write headers that PCL's description does not allow, and
rows of text stay the file's own.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lzf
import numpy as np
from numpy.typing import NDArray

from lpcompare.io.columns import AXES, COLORS, Holds, by_name, cloud_of, columns_of, find_roles, records
from lpcompare.io.rows import LONGEST_HEADER, Damaged, check_held, decoded, numbers
from lpcompare.types import Indices, PointCloud

_NO_VIEWPOINT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
_NORMALS = ("normal_x", "normal_y", "normal_z")
_PACKED = ("rgba", "rgb")
_LARGEST_COUNT = 9999
_LARGEST_RATIO = 300  # LZF makes nothing shorter than a 264th

HOLDS = {
    ".pcd": Holds(
        types=("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"),
        normals="f4",
        colors="u1",
        vectors=True,
        unfit=r"[\s\x00-\x1f\x7f-\xa0\ud800-\udfff]|^[#%=]",
        reserved=(*AXES, *_NORMALS, *COLORS, *_PACKED, "_"),
    )
}


@dataclass(frozen=True)
class File:
    """A file taken apart: lines of the header up to DATA, the type of a point, and the body."""

    head: list[bytes]
    encoding: bytes
    kind: np.dtype[Any]
    names: tuple[str, ...]
    shape: tuple[int, int]
    body: bytes

    @property
    def count(self) -> int:
        """Points of the file."""
        return self.shape[0] * self.shape[1]


def read(path: Path) -> PointCloud:
    """Coordinates, normals, the packed colour as red, green, blue, alpha; every other field as it is."""
    file = _take_apart(path)
    table = _table(file)
    fields = [(n, k) for n, k in zip(file.names, file.kind.names or (), strict=True) if n != "_"]
    columns: dict[str, NDArray[Any]] = {}
    for name, key in [(n, k) for n, k in fields if n.lower() in _PACKED and file.kind[k].itemsize == 4][:1]:
        words = np.ascontiguousarray(table[key]).view(np.uint32)
        shifts = (16, 8, 0, 24)[: len(name)]
        columns = {
            c: (words >> shift & 255).astype(np.uint8) for c, shift in zip(COLORS, shifts, strict=False)
        }
        fields.remove((name, key))
    others = [table[key] for _, key in fields]
    columns = by_name([*columns, *(name for name, _ in fields)], [*columns.values(), *others])
    placed = viewpoint(file.head) not in ((), _NO_VIEWPOINT)
    return cloud_of(columns, path.stem, beside=["its viewpoint, the pose of the sensor"] * placed)


def viewpoint(head: list[bytes]) -> tuple[float, ...]:
    """Place and rotation of the sensor, which are not applied to the coordinates; empty where none is said."""
    words = next((decoded(line).split()[1:] for line in head if _key(line) == b"VIEWPOINT"), [])
    try:
        return tuple(map(float, words))
    except ValueError:
        return ()


def write(path: Path, cloud: PointCloud) -> None:
    """Binary PCD; coordinates in single precision where that loses nothing, as PCL expects them."""
    columns = columns_of(cloud, _NORMALS)
    if np.array_equal(cloud.points.astype(np.float32), cloud.points, equal_nan=True):
        columns |= {axis: columns[axis].astype(np.float32) for axis in AXES}
    if cloud.colors is not None:
        red, green, blue, alpha = (
            columns.pop(c).astype(np.uint32) for c in ("red", "green", "blue", "alpha")
        )
        ahead = {n: columns[n] for n in (*AXES, *_NORMALS) if n in columns}
        columns = ahead | {"rgba": alpha << 24 | red << 16 | green << 8 | blue} | columns
    table = records(columns)
    kinds = [table.dtype[name] for name in columns]
    head = {
        "VERSION": ["0.7"],
        "FIELDS": list(columns),
        "SIZE": [kind.base.itemsize for kind in kinds],
        "TYPE": [kind.base.kind.upper() for kind in kinds],
        "COUNT": [kind.itemsize // kind.base.itemsize for kind in kinds],
        **{"WIDTH": [len(cloud)], "HEIGHT": [1], "VIEWPOINT": _NO_VIEWPOINT},
        **{"POINTS": [len(cloud)], "DATA": ["binary"]},
    }
    with path.open("wb") as file:
        file.writelines(f"{key} {' '.join(map(str, words))}\n".encode() for key, words in head.items())
        table.tofile(file)


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same header, encoding and values; an image-like cloud becomes a list of points."""
    file = _take_apart(source)
    encoding, body = file.encoding, b""
    if encoding == b"ascii":
        lines = _lines(file)
        body = b"".join(lines[i] for i in rows)
    else:
        kept = _table(file)[rows]
        body = kept.tobytes()
        if encoding == b"binary_compressed":
            whole = b"".join(np.ascontiguousarray(kept[key]).tobytes() for key in file.kind.names or ())
            packed = lzf.compress(whole)
            encoding = encoding if packed else b"binary"  # what cannot be made smaller
            body = struct.pack("<II", len(packed), len(whole)) + packed if packed else body
    target.write_bytes(head_of(file.head, len(rows)) + b"DATA " + encoding + b"\n" + body)
    width, height = file.shape
    return (f"the grid of {width} x {height} points becomes a list",) if height > 1 else ()


def head_of(head: list[bytes], count: int) -> bytes:
    """The lines of a header up to DATA, for a list of ``count`` points."""
    counts = {b"WIDTH": count, b"HEIGHT": 1, b"POINTS": count}
    lines = list(head)
    for i, line in enumerate(lines):
        if _key(line) in counts:
            lines[i] = re.sub(rb"(?<=\s)\d\S*", b"%d" % counts[_key(line)], line, count=1)
    return b"".join(lines)


def _take_apart(path: Path) -> File:
    return parse_header(path.read_bytes())


def parse_header(content: bytes) -> File:
    """The header, taken apart, and of the body what ``content`` has.

    Raises
    ------
    Damaged
        Fields without a type, a coordinate that comes twice, or more values a point than anyone stores.
    """
    end = re.search(rb"^[ \t]*DATA[ \t]+(\w+)[^\n]*\n", content[:LONGEST_HEADER], re.MULTILINE)
    if end is None:
        raise Damaged(f"its header has no line DATA in the first {LONGEST_HEADER} bytes")
    head = content[: end.start()].splitlines(keepends=True)
    words = {_key(line).decode("latin1"): decoded(line).split()[1:] for line in head if line.strip()}
    names = words.get("FIELDS") or words.get("COLUMNS") or []
    n = len(names)
    sizes, counts = (words.get(key) or [default] * n for key, default in (("SIZE", "4"), ("COUNT", "1")))
    types = words.get("TYPE") or ["F"] * n
    if not n or {len(sizes), len(counts), len(types)} != {n}:
        raise Damaged(
            f"its header has {n} fields, {len(sizes)} sizes, {len(types)} types and {len(counts)} counts"
        )
    numbers_of = [_integer(words, "COUNT", i, "1") for i in range(n)]
    if max(*numbers_of, n) > _LARGEST_COUNT:
        raise Damaged(f"it has more than {_LARGEST_COUNT} fields, or values of one field")
    kinds = [
        (f"f{i}", f"<{types[i].lower()}{sizes[i]}", (c,) * (c != 1)) for i, c in enumerate(numbers_of) if c
    ]
    for _, kind, _ in kinds:
        if kind[1:] not in HOLDS[".pcd"].types:
            raise Damaged(f"its header has a field of a type and size that are not known: {kind[1:40]}")
    points, width, height = (_integer(words, key, 0, "0") for key in ("POINTS", "WIDTH", "HEIGHT"))
    shape = (width, height) if width * height >= points else (points, 1)
    used = tuple(name for name, count in zip(names, numbers_of, strict=True) if count)
    find_roles(used)
    return File(head, end[1].lower(), np.dtype(kinds), used, shape, content[end.end() :])


def _key(line: bytes) -> bytes:
    """What a line of the header is about."""
    return (line.split(None, 1) or [b""])[0].upper()


def _integer(words: dict[str, list[str]], key: str, at: int, default: str) -> int:
    """A number that is not negative, of a line of the header that may be missing."""
    word = (words.get(key) or [default] * (at + 1))[at]
    try:
        value = int(word)
    except ValueError:
        value = -1
    if value < 0:
        raise Damaged(f"its header has {key} {word[:40]}")
    return value


def _lines(file: File) -> list[bytes]:
    """The lines of a body of text that are points."""
    lines = [line for line in file.body.splitlines(keepends=True) if line.partition(b"#")[0].strip()]
    if len(lines) != file.count:
        raise Damaged(f"it promises {file.count} points and holds {len(lines)}")
    return lines


def _table(file: File) -> NDArray[Any]:
    """The points as records."""
    size = file.count * file.kind.itemsize
    if file.encoding == b"ascii":
        return numbers(_lines(file), file.kind, comments="#")
    if file.encoding == b"binary":
        check_held("points", file.count, len(file.body) // file.kind.itemsize)
        return np.frombuffer(file.body, file.kind, file.count)
    if file.encoding != b"binary_compressed":
        raise Damaged(f"its encoding {file.encoding[:40]!r} is not known")
    check_held("bytes in its header of compression", 8, len(file.body))
    packed, whole = struct.unpack_from("<II", file.body)
    check_held("compressed bytes", packed, len(file.body) - 8)
    if whole != size or whole > _LARGEST_RATIO * max(packed, 1):
        raise Damaged(f"it promises {size} bytes of points and, of {packed} compressed bytes, {whole}")
    content = lzf.decompress(file.body[8 : 8 + packed], whole)
    table, at = np.empty(file.count, file.kind), 0
    for key in file.kind.names or ():
        part = file.kind[key]
        table[key] = np.frombuffer(content or b"", part, file.count, at)
        at += part.itemsize * file.count
    return table
