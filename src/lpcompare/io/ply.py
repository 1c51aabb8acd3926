"""PLY, ascii and binary: every property, comment and line of the header is kept.

Read here and not by a library, because headers hold any bytes, rows of text stay the file's own, and a list
that is longer than the file must not take the memory for it.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.columns import Holds, by_name, cloud_of, columns_of, exactly, records
from lpcompare.io.faces import fan_triangles, strip_triangles
from lpcompare.io.rows import LONGEST_HEADER, Damaged, check_held, decoded, numbers
from lpcompare.types import Indices, PointCloud

_TYPES = {
    **{"uchar": "u1", "char": "i1", "ushort": "u2", "short": "i2", "uint": "u4", "int": "i4"},
    **{"float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"},
}
_NAMES = {kind: name for name, kind in list(_TYPES.items())[:8]}
_ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_READ = ("vertex", "face", "tristrips")
_MOST_PROPERTIES = 5000

HOLDS = {".ply": Holds(types=tuple(_NAMES), normals="f8", colors="u1", faces=True)}


@dataclass
class Element:
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
    elements: list[Element]
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
    beside = [f"its element {e.name!r}" for e in file.elements if e.count and e.name not in _READ]
    return cloud_of(tables["vertex"], path.stem, _faces(tables, n_points), beside)


def write(path: Path, cloud: PointCloud) -> None:
    """Binary PLY: coordinates as doubles, colours as bytes, attributes in their own types, triangles."""
    columns = columns_of(cloud)
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(cloud)}"]
    lines += [f"property {_NAMES[values.dtype.str[1:]]} {name}" for name, values in columns.items()]
    parts = [records(columns)]
    if cloud.faces is not None:
        lines += [f"element face {len(cloud.faces)}", "property list uchar int vertex_indices"]
        parts += [records({"n": np.full(len(cloud.faces), 3, np.uint8), "v": cloud.faces.astype(np.int32)})]
    with path.open("wb") as file:
        file.write("\n".join([*lines, "end_header\n"]).encode("ascii"))
        for part in parts:
            part.tofile(file)


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
        No header of PLY, or one that is longer or has more properties than anyone writes; text with more
        rows than the header says.
    """
    content = path.read_bytes()
    order, head, elements, end = parse_header(content)
    for element in elements:
        if element.count * max(len(element.properties), 1) > len(content):
            raise Damaged(
                f"it promises {element.count} rows of {element.name!r} and holds {len(content)} bytes"
            )
    body = content[end:]
    rows = [line for line in body.splitlines(keepends=True) if line.strip()] if not order else []
    promised = sum(element.count for element in elements if element.properties)
    if not order and len(rows) > promised:
        raise Damaged(f"it promises {promised} rows and holds {len(rows)}")
    return _File(order, head, elements, body, rows)


def parse_header(content: bytes) -> tuple[str, list[bytes], list[Element], int]:
    """Byte order (empty of text), lines of the header, its elements, and where the body begins.

    Parameters
    ----------
    content : bytes
        The beginning of a file, with at least its header.

    Raises
    ------
    Damaged
        No header of PLY, or one that is longer or has more properties than anyone writes.
    """
    begin = re.match(rb"ply[ \t]*(\r\n|\n|\r)", content)
    if begin is None:
        raise Damaged("it does not begin with the line 'ply'")
    end = re.compile(rb"[\r\n]end_header[ \t]*" + begin[1]).search(content[:LONGEST_HEADER])
    if end is None:
        raise Damaged(f"its header has no line 'end_header' in the first {LONGEST_HEADER} bytes")
    head = [line + begin[1] for line in content[: end.end()].split(begin[1])[:-1]]
    order, elements = None, list[Element]()
    for i, line in enumerate(head):
        match line.split():
            case [b"format", kind, *_]:
                order = _ORDERS.get(kind)
            case [b"element", name, count, *_] if count.isdigit():
                elements.append(Element(decoded(name), int(count), [i]))
            case [b"property", *kinds, name] if elements and kinds:
                elements[-1].properties.append(_property(name, kinds))
                elements[-1].lines.append(i)
            case [b"property" | b"element", *_]:
                raise Damaged(f"its header has the line {line.strip()[:60]!r}")
    if order is None:
        raise Damaged(f"its header has none of the formats {b', '.join(_ORDERS).decode()}")
    named = [element.name for element in elements]
    if twice := next((name for name in named if named.count(name) > 1), None):
        raise Damaged(f"its header has more than one element {twice[:40]!r}")
    if sum(len(element.properties) for element in elements) > _MOST_PROPERTIES:
        raise Damaged(f"its header has more than {_MOST_PROPERTIES} properties")
    return order, head, elements, end.end()


def _property(name: bytes, kinds: list[bytes]) -> tuple[str, str, str]:
    """Name, type and, of a list, type of its count."""
    types = [_TYPES.get(decoded(kind), "") for kind in kinds[kinds[0] == b"list" :]]
    if not all(types) or len(types) != 1 + (kinds[0] == b"list"):
        raise Damaged(f"its header has a property {name[:40]!r} of type {b' '.join(kinds)[:40]!r}")
    return decoded(name), types[-1], types[0] if len(types) == 2 else ""


def _table(file: _File, element: Element, start: int) -> tuple[dict[str, NDArray[Any]], NDArray[np.intp]]:
    """The columns of an element, and where in the body, after ``start``, each of its rows ends.

    Lists that are all of one length, such as triangles, are read at once.
    """
    names, count = [name for name, *_ in element.properties], element.count
    values = [f"v{i}" for i in range(len(names))]
    if not count or not names:
        return {}, np.full(count + 1, start)
    lines = file.rows[start : start + count]
    if not file.order:
        check_held(f"rows of {element.name!r}", count, len(lines))
    one = _rows(file, element, start, 1)[0]
    kind = np.dtype(
        [part for i, values in enumerate(one) for part in _record(file.order, element, i, len(values[0]))]
    )
    table = None
    if not file.order:
        with suppress(Damaged):
            table = numbers(lines, kind)
    elif count * kind.itemsize <= len(file.body) - start:
        table = np.frombuffer(file.body, kind, count, start)
    if table is not None and all((table[n] == table[n][0]).all() for n in kind.names or () if n[0] == "n"):
        step = kind.itemsize if file.order else 1
        return by_name(names, map(table.__getitem__, values)), start + step * np.arange(count + 1)
    found, ends = _rows(file, element, start, count)
    lists = [np.fromiter(values, object, count) for values in found]
    columns = [np.concatenate(v) if not p[2] else v for v, p in zip(lists, element.properties, strict=True)]
    return by_name(names, columns), ends if file.order else np.arange(start, start + count + 1)


def _record(order: str, element: Element, i: int, length: int) -> list[tuple[str, str, tuple[int, ...]]]:
    """The fields of a property in a record: a list's count and its values."""
    _, kind, counter = element.properties[i]
    value = (f"v{i}", order + kind, (length,) if counter else ())
    return [(f"n{i}", order + counter, ()), value] if counter else [value]


def _rows(
    file: _File, element: Element, start: int, count: int
) -> tuple[list[list[NDArray[Any]]], NDArray[np.intp]]:
    """The values of each property in some rows, one row after the other, and where each row ends."""
    words = [line.split() for line in file.rows[start : start + count]]
    flat = _floats([word for line in words for word in line])
    found: list[list[NDArray[Any]]] = [[] for _ in element.properties]
    at = start if file.order else 0
    ends = [at]

    def take(kind: str, length: int) -> NDArray[Any]:
        nonlocal at
        step = int(kind[1]) if file.order else 1
        check_held("values", at + max(length, 0) * step, len(file.body if file.order else flat))
        first, at = at, at + length * step
        if file.order:
            return np.frombuffer(file.body, file.order + kind, length, first)
        values = flat[first:at] if kind[0] == "f" else exactly(flat[first:at], kind)
        if values is None:
            raise Damaged(f"a row of {element.name!r} has a value that is not of its type {_NAMES[kind]}")
        return values.astype(kind)

    for _ in range(count):
        for values, (name, kind, counter) in zip(found, element.properties, strict=True):
            length = int(take(counter, 1)[0]) if counter else 1
            if length < 0:
                raise Damaged(f"a list {name!r} has {length} values")
            values.append(take(kind, length))
        ends.append(at)
    if not file.order and not np.array_equal(np.diff(ends), [len(line) for line in words]):
        raise Damaged(f"a row of {element.name!r} has another number of values than its header says")
    return found, np.array(ends)


def _floats(words: list[bytes]) -> NDArray[np.float64]:
    try:
        return np.array(words, "S").astype(np.float64)
    except ValueError:
        raise Damaged("a row has a word that is no number") from None


def _some(file: _File, ends: NDArray[np.intp], rows: Indices) -> list[bytes]:
    """Rows of an element as they are in the file."""
    if not file.order:
        return [file.rows[i] for i in ends[rows].tolist()]
    steps = np.unique(np.diff(ends))
    if len(steps) == 1 and steps[0]:
        return [np.frombuffer(file.body, f"V{steps[0]}", len(ends) - 1, int(ends[0]))[rows].tobytes()]
    return [file.body[ends[i] : ends[i + 1]] for i in rows.tolist()]


def _faces(tables: dict[str, dict[str, NDArray[Any]]], n_points: int) -> NDArray[np.intp] | None:
    """The triangles of strips or faces, whichever there are."""
    for element, triangles in (("tristrips", strip_triangles), ("face", fan_triangles)):
        for name in _CORNERS:
            if len(corners := tables.get(element, {}).get(name, ())):
                return triangles(corners, n_points)
    return None
