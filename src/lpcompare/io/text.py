"""Rows of numbers: XYZ, PTS, TXT, ASC, CSV.

Read here and not by MeshLab, which rounds some of these to single precision, leaves rows out and knows
no further columns. Kept rows are the file's own bytes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lpcompare.io.checks import checked_points
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"normals", "colors", "attributes"})

_COMMENTS = (b"#", b"//")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_NUMBER = re.compile(rb"[+-]?(\d|\.\d|nan|inf)", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(rb"\d,\d+(\s+|;)[+-]?\d+,\d")


@dataclass(frozen=True)
class _Table:
    """A text file taken apart: its lines, which of them are points, and what the columns are called."""

    lines: list[bytes]
    rows: list[int]
    names: list[str]
    count_line: int | None


def read(path: Path) -> PointCloud:
    """The columns x, y and z, by name or the first three; every other column is an attribute."""
    table = _take_apart(path)
    texts = [_separated(table.lines[i]) for i in table.rows]
    values = np.loadtxt(texts, ndmin=2, comments=None, encoding="latin1")
    names = _column_names(table.names, values.shape[1])
    axes = [names.index(axis) for axis in "xyz"]
    points = checked_points(values[:, axes], path.name)
    attributes = {name: values[:, i] for i, name in enumerate(names) if i not in axes}
    return PointCloud(points, attributes=attributes, name=path.stem)


def write(path: Path, cloud: PointCloud) -> None:
    """One point a line with all its digits; a line of column names where there are more than x, y, z."""
    columns = {axis: cloud.points[:, i] for i, axis in enumerate("xyz")}
    if cloud.normals is not None:
        columns |= {f"n{axis}": cloud.normals[:, i] for i, axis in enumerate("xyz")}
    if cloud.colors is not None:
        columns |= {c: cloud.colors[:, i] for i, c in enumerate(("red", "green", "blue", "alpha"))}
    for name, values in cloud.attributes.items():
        flat = values.reshape(len(cloud), -1)
        flat = flat.astype(np.uint8) if flat.dtype.kind == "b" else flat  # "True" could not be read back
        suffixes = [""] if flat.shape[1] == 1 else [f"_{i}" for i in range(flat.shape[1])]
        columns |= {re.sub(r"[\s,;]+", "_", name) + s: c for s, c in zip(suffixes, flat.T, strict=True)}
    separator = "," if path.suffix.lower() == ".csv" else " "
    named = len(columns) > 3 or separator == ","
    with path.open("w", encoding="utf-8") as file:
        if named:
            file.write(("" if separator == "," else "# ") + separator.join(columns) + "\n")
        for row in zip(*(c.tolist() for c in columns.values()), strict=True):
            file.write(separator.join(map(repr, row)) + "\n")


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same lines without those of the other points; a line that counts the points counts anew."""
    table = _take_apart(source)
    dropped = set(table.rows) - {table.rows[i] for i in rows}
    with target.open("wb") as file:
        for i, line in enumerate(table.lines):
            if i == table.count_line:
                file.write(re.sub(rb"\d\S*", str(len(rows)).encode(), line, count=1))
            elif i not in dropped:
                file.write(line)


def _take_apart(path: Path) -> _Table:
    """Sort the lines into points, comments, column names and a count.

    Raises
    ------
    ValueError
        Decimal commas, words between the numbers, or another number of rows than the file says.
    """
    lines = path.read_bytes().splitlines(keepends=True)
    rows, names, count_line = list[int](), b"", None
    for i, line in enumerate(lines):
        text = line.strip().removeprefix(_BYTE_ORDER_MARK)
        if text.startswith(_COMMENTS):
            names = text.lstrip(b"#/") if not rows else names
        elif _NUMBER.match(text):
            if rows or count_line is not None or len(_separated(text).split()) > 1:
                rows.append(i)
            else:
                count_line = i
        elif text and any(other.strip() for other in lines[:i] if not other.startswith(_COMMENTS)):
            raise ValueError(f"line {i + 1} is {text[:40]!r}, not numbers")
        elif text:
            names = text
    _check_rows(lines, rows, count_line)
    return _Table(lines, rows, _separated(names).decode("utf-8", "replace").split(), count_line)


def _check_rows(lines: list[bytes], rows: list[int], count_line: int | None) -> None:
    if not rows:
        raise ValueError("it has no rows of numbers")
    if _DECIMAL_COMMA.search(lines[rows[0]]):
        raise ValueError("its numbers have decimal commas; replace them by points")
    if count_line is not None and int(lines[count_line]) != len(rows):
        raise ValueError(f"it promises {int(lines[count_line])} points and holds {len(rows)}")


def _separated(line: bytes) -> bytes:
    return line.replace(b",", b" ").replace(b";", b" ")


def _column_names(header: list[str], width: int) -> list[str]:
    """The header's names if they fit and name the axes, else x, y, z, column_4, ..."""
    names = [name.strip("\"'").lower() for name in header]
    if len(names) == width and {"x", "y", "z"} <= set(names) and len(set(names)) == width:
        return names
    if width < 3:
        raise ValueError(f"its rows have {width} columns; x, y and z are needed")
    return ["x", "y", "z", *(f"column_{i}" for i in range(4, width + 1))]
