"""Rows of numbers: XYZ, PTS, TXT, ASC, CSV, and the scans of PTX. Kept rows are the file's own bytes.

What separates the columns, which line names them and which lines are points is decided once for a file, from
its first row; the names decide which columns are coordinates.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.columns import (
    AXES,
    COLORS,
    NUMBERS,
    Holds,
    by_name,
    cloud_of,
    columns_of,
    find_roles,
    with_bytes,
)
from lpcompare.io.rows import Damaged, decoded, numbers
from lpcompare.types import Indices, PointCloud

_SUFFIXES = (".asc", ".csv", ".pts", ".txt", ".xyz")
_COMMENTS = (b"#", b"//", b"%")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_PLAIN_NUMBER = re.compile(rb"[+-]?\d+(\.\d*)?(e[+-]?\d+)?([\s,;]|$)", re.IGNORECASE)
_FIRST_CELL = re.compile(rb"\"?\s*([^\s,;\"]+)")
_QUOTED = re.compile(rb"\"[^\"]*\"")
_COMMA_IN_NUMBER = re.compile(rb"\d,\d")
_EXCEL_SEPARATOR = re.compile(rb"\"?sep=.\"?", re.IGNORECASE)
_MISSING = frozenset(
    ("", "na", "n/a", "nan", "-nan", "null", "none", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#ind")
)
_NO_COMMAS = (
    "its numbers have decimal commas, or marks between thousands; export it with decimal points and without "
    "such marks"
)
_LEICA = (*AXES, "intensity", *COLORS[:3])
_LARGEST_DOUBLE = 2**53
_PTX_HEADER, _PTX_MATRIX = 10, slice(6, 10)
_MOST_SCANS = 10_000

HOLDS = dict.fromkeys(
    _SUFFIXES,
    Holds(
        types=NUMBERS, normals="f8", colors="f8", unfit=r"[\s,;\"'\x00-\x1f\x7f-\x9f\ud800-\udfff]+|^[#=+@%-]"
    ),
)


@dataclass(frozen=True)
class _Table:
    """A text file taken apart: its lines, which of them are points, and what the columns are called."""

    lines: list[bytes]
    rows: list[int]
    names: list[str]
    separator: str
    count_line: int | None


def read(path: Path) -> PointCloud:
    """The coordinates by name or, in a file without names, the first three columns; the others by name."""
    if path.suffix.lower() == ".ptx":
        return _read_ptx(path)
    table = _take_apart(path)
    columns = _columns([table.lines[i] for i in table.rows], table.separator)
    if len(columns) < 3:
        raise Damaged(f"its rows have {len(columns)} columns; x, y and z are needed")
    leica = path.suffix.lower() == ".pts" and len(columns) == len(_LEICA)
    first = _LEICA if leica else AXES
    names = table.names or [*first, *(f"column_{i + 1}" for i in range(len(first), len(columns)))]
    named = _named(names, columns)
    return cloud_of(with_bytes(named) if leica else named, path.stem)


def write(path: Path, cloud: PointCloud) -> None:
    """One point a line with all its digits; a line of column names where there are more than x, y, z."""
    columns = columns_of(cloud)
    separator = "," if path.suffix.lower() == ".csv" else " "
    with path.open("w", encoding="utf-8", newline="\n") as file:
        if len(columns) > 3 or separator == ",":
            file.write(("" if separator == "," else "# ") + separator.join(columns) + "\n")
        for row in zip(*(c.tolist() for c in columns.values()), strict=True):
            file.write(separator.join(map(repr, row)) + "\n")


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same lines without those of the other points; a line that counts the points counts anew."""
    table = _take_apart(source)
    dropped = set(table.rows) - {table.rows[i] for i in rows}
    with target.open("wb") as file:
        for i, line in enumerate(table.lines):
            if i == table.count_line:
                file.write(re.sub(rb"\d\S*", str(len(rows)).encode(), line, count=1))
            elif i not in dropped:
                file.write(line)
    return ()


def _take_apart(path: Path) -> _Table:
    """Sort the lines into points, comments, column names and a count.

    Raises
    ------
    Damaged
        Decimal commas, words between the numbers, names that do not fit, or another number of rows than the
        file says.
    """
    content = path.read_bytes()
    if content.startswith(_UTF_16):
        raise Damaged("its text is UTF-16; save it as UTF-8")
    lines = content.splitlines(keepends=True)
    rows, comments, header, count_line, odd = list[int](), list[bytes](), b"", None, -1
    for i, line in enumerate(lines):
        text = line.strip() if i else line.removeprefix(_BYTE_ORDER_MARK).strip()
        if text.startswith(_COMMENTS):
            comments += [] if rows else [text.lstrip(b"#/%")]
        elif _begins_with_number(text):
            if rows or count_line is not None or len(re.split(rb"[\s,;]+", text)) > 1:
                rows.append(i)
            else:
                count_line = i
        elif not text or (not i and _EXCEL_SEPARATOR.fullmatch(text)):
            continue
        elif not rows and not header:
            header = text
        else:
            odd = odd if odd >= 0 else i
            rows.append(i)
    separator = _separator(lines[rows[0]], header or b"".join(comments[-1:])) if rows else " "
    if not rows or (odd >= 0 and (not header or separator == " ")):
        line = max(odd, 0)
        begin = f", line {line + 1} is {lines[line].strip()[:40]!r}, not numbers" if lines else ""
        raise Damaged(f"it has no rows of numbers{begin}" if odd < 0 else begin[2:])
    _check_count(lines, rows, count_line)
    row = _cells(lines[rows[0]], separator)
    names = _names(header, row, separator) if header else _names_of_comments(comments, row, separator)
    return _Table(lines, rows, names, separator, count_line)


def _begins_with_number(text: bytes) -> bool:
    if _PLAIN_NUMBER.match(text):  # almost every line of a scan
        return True
    first = _FIRST_CELL.match(text)
    if first is None:
        return False
    try:
        float(first[1])
    except ValueError:
        return first[1].lower().decode("latin-1") in _MISSING
    return True


def _check_count(lines: list[bytes], rows: list[int], count_line: int | None) -> None:
    try:
        promised = len(rows) if count_line is None else int(lines[count_line].removeprefix(_BYTE_ORDER_MARK))
    except ValueError:
        raise Damaged(
            f"its first line {lines[count_line or 0].strip()[:40]!r} is no number of points"
        ) from None
    if promised != len(rows):
        raise Damaged(f"it promises {promised} points and holds {len(rows)}")


def _separator(row: bytes, header: bytes) -> str:
    """What stands between the columns of a row, and of the names: ";", a tab, "," or " ", any white space.

    Raises
    ------
    Damaged
        The numbers have commas in them, or the row is separated in two ways.
    """
    plain, titles = (_QUOTED.sub(b"0", line).strip(b"\r\n") for line in (row, header))
    for mark in (mark for mark in (b";", b"\t", b",") if mark in plain):
        cells = [cell.strip() for cell in plain.split(mark)]
        named = titles.count(mark) > 1 and abs(titles.count(mark) + 1 - len(cells)) < 2
        if named or not any(len(cell.split()) > 1 for cell in cells):
            if mark != b"," and _COMMA_IN_NUMBER.search(plain):
                raise Damaged(_NO_COMMAS)
            return mark.decode()
    if _COMMA_IN_NUMBER.search(plain):
        raise Damaged(_NO_COMMAS)
    if set(b",;") & set(plain):
        raise Damaged(f"its row {row.strip()[:40]!r} is separated in two ways; separate all columns in one")
    return " "


def _cells(line: bytes, separator: str) -> list[str]:
    """The columns of a line, without their quotes."""
    text = decoded(line.removeprefix(_BYTE_ORDER_MARK)).strip("\r\n")
    if separator == " ":
        text = " ".join(text.split())
    return [cell.strip() for cell in next(csv.reader([text], delimiter=separator, skipinitialspace=True), [])]


def _names(header: bytes, row: list[str], separator: str) -> list[str]:
    """The names of a line of names; a number before each row, or a separator behind it, needs none.

    Raises
    ------
    Damaged
        The names are not as many as the columns.
    """
    if names := _fitting(header, len(row), separator):
        return names
    names = _fitting(header, len(row) - 1, separator)
    if "points" not in find_roles(names):
        raise Damaged(f"its line of names {header[:40]!r} does not fit its rows of {len(row)} columns")
    return ["", *names] if row[-1] else [*names, ""]


def _names_of_comments(comments: list[bytes], row: list[str], separator: str) -> list[str]:
    """The names of the last comment, or of what follows its ":", that names the axes and as many columns.

    A comment of as many cells between the rows' own marks is a line of names too, whatever they are.
    """
    for comment in reversed(comments):
        for line in (comment, comment.partition(b":")[2]):
            names = _fitting(line, len(row), separator)
            if "points" in find_roles(names):
                return names
    titles = (_cells(comment, separator) for comment in reversed(comments) if separator != " ")
    return next((names for names in titles if len(names) == len(row)), [])


def _fitting(line: bytes, n_columns: int, separator: str) -> list[str]:
    """The cells of a line if they are so many, not counting a separator at its end; else none."""
    for mark in dict.fromkeys((separator, ",", ";", "\t", " ")):
        names = _cells(line, mark)
        if len(names) == n_columns + 1 and not names[-1]:
            return names[:-1]
        if len(names) == n_columns:
            return names
    return []


def _named(names: list[str], columns: list[NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """The columns by name; one without a name and values is none, a name that comes again is numbered."""
    numbered = [name or f"column_{i}" for i, name in enumerate(names, start=1)]
    used = [
        bool(name) or column.dtype.kind != "f" or not np.isnan(column).all()
        for name, column in zip(names, columns, strict=True)
    ]
    return by_name(compress(numbered, used), compress(columns, used))


def _columns(lines: list[bytes], separator: str) -> list[NDArray[Any]]:
    """Each column as numbers, or as words where it is not made of numbers; an empty cell is NaN."""
    try:
        table = numbers(lines, separator=None if separator == " " else separator, quotechar='"')
    except Damaged:
        table = None
    if table is not None and not (np.abs(table) >= _LARGEST_DOUBLE).any():
        return list(table.T)
    rows = [_cells(line, separator) for line in lines]
    wrong = next((i for i, row in enumerate(rows) if len(row) != len(rows[0])), None)
    if wrong is not None:
        raise Damaged(
            f"the row {lines[wrong].strip()[:40]!r} has {len(rows[wrong])} columns, not {len(rows[0])}"
        )
    return [_column(words) for words in zip(*rows, strict=True)]


def _column(words: Sequence[str]) -> NDArray[Any]:
    """Whole numbers that a double would round as integers, other numbers as doubles, else words.

    Whole numbers that no integer of 64 bits holds are words, so that none is rounded.
    """
    try:
        column = np.array(["nan" if w.lower() in _MISSING else w.replace("_", "?") for w in words]).astype(
            float
        )
    except ValueError:
        if any(re.fullmatch(r"[+-]?\d+,\d+", word) for word in words):
            raise Damaged(_NO_COMMAS) from None
        return np.array(words)
    if np.abs(column).max(initial=0) >= _LARGEST_DOUBLE and all(re.fullmatch(r"[+-]?\d+", w) for w in words):
        whole = [int(word) for word in words]
        kinds = (
            k
            for k in (np.int64, np.uint64)
            if np.iinfo(k).min <= min(whole) and max(whole) <= np.iinfo(k).max
        )
        kind = next(kinds, None)
        return np.array(words) if kind is None else np.array(whole, kind)
    return column


def _read_ptx(path: Path) -> PointCloud:
    """Every scan moved to its place, with intensity and colours; a ray without an echo ('0 0 0') is NaN."""
    lines = [line for line in path.read_bytes().splitlines() if line.strip()]
    scans, start = list[NDArray[np.float64]](), 0
    while start < len(lines):
        scans.append(_scan(lines, start))
        start += _PTX_HEADER + len(scans[-1])
        if len(scans) > _MOST_SCANS:
            raise Damaged(f"it has more than {_MOST_SCANS} scans")
    width = max((scan.shape[1] for scan in scans), default=3)
    table = np.concatenate(
        [np.pad(s, ((0, 0), (0, width - s.shape[1])), constant_values=np.nan) for s in scans]
        or [np.empty((0, 3))]
    )
    return cloud_of(with_bytes(dict(zip(_LEICA, table.T, strict=False))), path.stem)


def _scan(lines: list[bytes], start: int) -> NDArray[np.float64]:
    """Rows 'x y z intensity red green blue' of a scan, in place.

    Two numbers say how many rows there are; the pose follows in four lines, and again as a matrix whose last
    row is the shift.
    """
    head = lines[start : start + _PTX_HEADER]
    if len(head) < _PTX_HEADER:
        raise Damaged(f"a scan ends in its header, after {len(head)} of {_PTX_HEADER} lines")
    (columns,), (rows,) = numbers(head[:2], np.int64)
    promised, held = int(columns) * int(rows), len(lines) - start - _PTX_HEADER
    if min(columns, rows) < 1 or promised > held:
        raise Damaged(f"a scan promises {columns} x {rows} points and there are {held} lines")
    matrix = numbers(head[_PTX_MATRIX])
    table = numbers(lines[start + _PTX_HEADER : start + _PTX_HEADER + promised])
    if matrix.shape != (4, 4) or table.shape[1] not in (3, 4, 7):
        raise Damaged(f"a scan has a matrix of shape {matrix.shape} and {table.shape[1]} columns")
    if not np.isfinite(matrix).all() or np.linalg.matrix_rank(matrix[:3, :3]) < 3:
        raise Damaged("a scan has a matrix that turns its points into less than space")
    table[~table[:, :3].any(axis=1), :3] = np.nan
    table[:, :3] = table[:, :3] @ matrix[:3, :3] + matrix[3, :3]
    return table
