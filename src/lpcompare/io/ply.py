"""PLY, ascii and binary: every property, comment and line of the header is kept.

Read here and not by a library, because headers hold any bytes, rows of text stay the file's own, and a list
that is longer than the file must not take the memory for it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.columns import Holds, cloud_of, columns_of, exactly
from lpcompare.io.faces import fan_triangles, strip_triangles
from lpcompare.io.rows import Damaged, check_held, decoded, numbers
from lpcompare.types import Indices, PointCloud

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"},
}
_NAMES = {kind: name for name, kind in reversed(_TYPES.items())}
_ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_LONGEST_HEADER = 2**20
_MOST_PROPERTIES = 5000

HOLDS = {
    ".ply": Holds(
        types=("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"), normals="f8", colors="u1", faces=True
    )
}


@dataclass
class _Element:
    """A table of the file: its lines of the header, and each property's name, type and type of a count."""

    name: str
    count: int
    lines: list[int]
    properties: list[tuple[str, str, str]] = field(default_factory=list)


@dataclass(frozen=True)
class _File:
    """A file taken apart; ``rows`` are the lines of a body of text, else the body is bytes."""

    order: str
    head: list[bytes]
    elements: list[_Element]
    body: bytes
    rows: list[bytes]


def read(path: Path) -> PointCloud:
    """The vertices with their properties; faces and triangle strips as triangles."""
    file = _take_apart(path)
    tables: dict[str, dict[str, NDArray[Any]]] = {}
    start = 0
    for element in file.elements:
        tables[element.name], ends = _table(file, element, start)
        start = int(ends[-1])
    if not tables.get("vertex"):
        raise Damaged("it has no element 'vertex' with properties x, y and z")
    n_points = len(next(iter(tables["vertex"].values())))
    return cloud_of(tables["vertex"], path.stem, _faces(tables, n_points))


def write(path: Path, cloud: PointCloud) -> None:
    """Binary PLY: coordinates as doubles, colours as bytes, attributes in their own types, triangles."""
    columns = columns_of(cloud)
    table = np.empty(len(cloud), [(name, values.dtype.newbyteorder("<")) for name, values in columns.items()])
    for name, values in columns.items():
        table[name] = values
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(cloud)}"]
    lines += [f"property {_NAMES[values.dtype.str[1:]]} {name}" for name, values in columns.items()]
    with path.open("wb") as file:
        if cloud.faces is not None:
            lines += [f"element face {len(cloud.faces)}", "property list uchar int vertex_indices"]
        file.write("\n".join([*lines, "end_header\n"]).encode("ascii"))
        table.tofile(file)
        if cloud.faces is not None:
            faces = np.empty(len(cloud.faces), [("count", "u1"), ("corners", "<i4", (3,))])
            faces["count"], faces["corners"] = 3, cloud.faces
            faces.tofile(file)


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same file with some of its vertices; elements that name vertices, such as faces, are left out."""
    file = _take_apart(source)
    head, body, start = list(file.head), list[bytes](), 0
    for element in file.elements:
        _, ends = _table(file, element, start)
        if element.name == "vertex":
            at = element.lines[0]
            head[at] = re.sub(rb"\d+(?=\s*$)", b"%d" % len(rows), head[at])
            body += _some(file, ends, rows)
        elif any(name.startswith("vertex") for name, *_ in element.properties):
            head = [b"" if i in element.lines else line for i, line in enumerate(head)]
        else:
            body += _some(file, ends, np.arange(element.count))
        start = int(ends[-1])
    target.write_bytes(b"".join(head + body))
    return ()


def _take_apart(path: Path) -> _File:
    """The header's elements, and the body.

    Raises
    ------
    Damaged
        No header of PLY, or one that is longer or has more properties than anyone writes.
    """
    content = path.read_bytes()
    begin = re.match(rb"ply[ \t]*(\r\n|\n|\r)", content)
    if begin is None:
        raise Damaged("it does not begin with the line 'ply'")
    end = re.compile(rb"(?:\r|\n)end_header[ \t]*" + begin[1]).search(content[:_LONGEST_HEADER])
    if end is None:
        raise Damaged(
            f"its header has no line 'end_header' in the first {min(len(content), _LONGEST_HEADER)} bytes"
        )
    head = [line + begin[1] for line in content[: end.end()].split(begin[1])[:-1]]
    order, elements = None, list[_Element]()
    for i, line in enumerate(head):
        words = line.split()
        match words:
            case [b"format", kind, *_]:
                order = _ORDERS.get(kind)
            case [b"element", name, count, *_] if count.isdigit():
                elements.append(_Element(decoded(name), int(count), [i]))
            case [b"property", *kinds, name] if elements and kinds:
                elements[-1].properties.append(_property(name, kinds))
                elements[-1].lines.append(i)
            case [b"property" | b"element", *_]:
                raise Damaged(f"its header has the line {line.strip()[:60]!r}")
    if order is None:
        raise Damaged(
            "its header has no format that is known: ascii, binary_little_endian or binary_big_endian"
        )
    if sum(len(element.properties) for element in elements) > _MOST_PROPERTIES:
        raise Damaged(f"its header has more than {_MOST_PROPERTIES} properties")
    _check_counts(elements, len(content))
    body = content[end.end() :]
    rows = [line for line in body.splitlines(keepends=True) if line.strip()] if not order else []
    return _File(order, head, elements, body, rows)


def _property(name: bytes, kinds: list[bytes]) -> tuple[str, str, str]:
    """Name, type and, of a list, type of its count."""
    types = [_TYPES.get(decoded(kind), "") for kind in kinds if kind != b"list"]
    if len(types) != len(kinds) - (kinds[0] == b"list") or len(types) not in (1, 2) or not all(types):
        raise Damaged(f"its header has a property {name[:40]!r} of type {b' '.join(kinds)[:40]!r}")
    return decoded(name), types[-1], types[0] if len(types) == 2 else ""


def _check_counts(elements: list[_Element], size: int) -> None:
    for element in elements:
        if element.count * max(len(element.properties), 1) > size:
            raise Damaged(f"it promises {element.count} rows of {element.name!r} and holds {size} bytes")


def _table(file: _File, element: _Element, start: int) -> tuple[dict[str, NDArray[Any]], NDArray[np.intp]]:
    """The columns of an element, and where in the body each of its rows ends, after ``start``.

    Lists that are all of one length, such as triangles, are read at once.
    """
    if not element.count or not element.properties:
        return {}, np.full(element.count + 1, start)
    if file.order == "":
        check_held(f"rows of {element.name!r}", element.count, len(file.rows) - start)
    lengths = [len(values) for values in _rows(file, element, start, 1)[0][0]]
    kind = np.dtype(
        [
            part
            for i, (_, kind, counter) in enumerate(element.properties)
            for part in ([(f"n{i}", file.order + counter)] if counter else [])
            + [(f"v{i}", file.order + kind, (lengths[i],) if counter else ())]
        ]
    )
    table = _at_once(file, element, start, kind)
    if table is not None and all(
        (table[f"n{i}"] == lengths[i]).all() for i, p in enumerate(element.properties) if p[2]
    ):
        step = kind.itemsize if file.order else 1
        columns = {p[0]: table[f"v{i}"] for i, p in enumerate(element.properties)}
        return columns, start + step * np.arange(element.count + 1)
    found, ends = _rows(file, element, start, element.count)
    columns = {}
    for (name, _, counter), values in zip(element.properties, zip(*found, strict=True), strict=True):
        columns[name] = np.fromiter(values, object, len(values)) if counter else np.concatenate(values)
    return columns, np.array([start, *ends])


def _at_once(file: _File, element: _Element, start: int, kind: np.dtype[Any]) -> NDArray[Any] | None:
    """The rows as one array of records, or None where they are not all alike."""
    if file.order:
        room = len(file.body) - start
        return (
            np.frombuffer(file.body, kind, element.count, start)
            if element.count * kind.itemsize <= room
            else None
        )
    try:
        return numbers(file.rows[start : start + element.count], kind)
    except Damaged:
        return None


def _rows(
    file: _File, element: _Element, start: int, count: int
) -> tuple[list[list[NDArray[Any]]], list[int]]:
    """The values of each property of some rows, one row after the other, and where each row ends."""
    rows, ends = [], []
    for _ in range(count):
        words = file.rows[start].split() if not file.order else []
        row, at = [], 0 if not file.order else start
        for name, kind, counter in element.properties:
            length = 1
            if counter:
                values, at = _values(file, words, at, counter, 1)
                length = int(values[0])
            if length < 0:
                raise Damaged(f"a list {name!r} has {length} values")
            values, at = _values(file, words, at, kind, length)
            row.append(values)
        if at < len(words):
            raise Damaged(f"a row of {element.name!r} has {len(words)} values, not {at}")
        start = at if file.order else start + 1
        rows.append(row)
        ends.append(start)
    return rows, ends


def _values(file: _File, words: list[bytes], at: int, kind: str, length: int) -> tuple[NDArray[Any], int]:
    """Some values of one type at a place of the body, or of a row's words, and the place behind them."""
    if file.order:
        end = at + length * int(kind[1])
        check_held("bytes", end, len(file.body))
        return np.frombuffer(file.body, file.order + kind, length, at), end
    check_held("values in a row", at + length, len(words))
    try:
        values = exactly(
            np.array(words[at : at + length], "S").astype(np.float64), kind if kind[0] != "f" else "f8"
        )
    except ValueError:
        values = None
    if values is None:
        raise Damaged(f"{b' '.join(words[at : at + length])[:40]!r} is no value of type {_NAMES[kind]}")
    return values.astype(kind), at + length


def _some(file: _File, ends: NDArray[np.intp], rows: Indices) -> list[bytes]:
    """Rows of an element as they are in the file."""
    if not file.order:
        return [file.rows[i] for i in (ends[:-1][rows]).tolist()]
    steps = np.diff(ends)
    if len(steps) and (steps == steps[0]).all():
        table = (
            np.frombuffer(file.body, f"V{steps[0]}", len(steps), int(ends[0])) if steps[0] else np.empty(0)
        )
        return [table[rows].tobytes() if steps[0] else b""]
    return [file.body[ends[i] : ends[i + 1]] for i in rows.tolist()]


def _faces(tables: dict[str, dict[str, NDArray[Any]]], n_points: int) -> NDArray[np.intp] | None:
    for element in ("tristrips", "face"):
        corners = next((tables[element][n] for n in _CORNERS if n in tables.get(element, {})), None)
        if corners is not None and len(corners) and element == "face":
            return fan_triangles(corners, n_points)
        if corners is not None and len(corners):
            return strip_triangles(np.concatenate([np.append(s, -1) for s in corners]), n_points)
    return None
