"""PTX of laser scanners: the points of one or more scans, each moved to its place. It cannot be written.

Read here and not by MeshLab, which takes the first scan alone, leaves out points and reads half a file
without a word.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.checks import checked_points
from lpcompare.types import PointCloud

_HEADER_LINES = 10
_MATRIX_LINES = slice(6, 10)


def read(path: Path) -> PointCloud:
    """Coordinates, intensity, colours where every scan has them; rows '0 0 0' are rays without an echo."""
    lines = [line for line in path.read_bytes().splitlines() if line.strip()]
    scans: list[NDArray[np.float64]] = []
    while lines:
        scan, lines = _first_scan(lines)
        scans.append(scan)
    width = min((scan.shape[1] for scan in scans), default=0)
    table = np.concatenate([scan[:, :width] for scan in scans]) if scans else np.empty((0, 3))
    return PointCloud(
        checked_points(table[:, :3], path.name),
        colors=np.column_stack([table[:, 4:7] / 255, np.ones(len(table))]) if width == 7 else None,
        attributes={"intensity": table[:, 3]} if width > 3 else {},
        name=path.stem,
    )


def _first_scan(lines: list[bytes]) -> tuple[NDArray[np.float64], list[bytes]]:
    """Rows 'x y z intensity red green blue' of the first scan, in place, and the lines behind it.

    Two numbers say how many rows there are; the pose follows in four lines, and again as a matrix whose last
    row is the shift.
    """
    if len(lines) < _HEADER_LINES:
        raise ValueError(f"a scan ends in its header, after {len(lines)} of {_HEADER_LINES} lines")
    columns, rows = int(lines[0]), int(lines[1])
    promised, held = columns * rows, len(lines) - _HEADER_LINES
    if min(columns, rows) < 1 or promised > held:
        raise ValueError(f"a scan promises {columns} x {rows} points and there are {held} lines")
    matrix = _numbers(lines[_MATRIX_LINES])
    table = _numbers(lines[_HEADER_LINES : _HEADER_LINES + promised])
    if matrix.shape != (4, 4) or table.shape[1] not in (3, 4, 7):
        raise ValueError(f"a scan has a matrix of shape {matrix.shape} and {table.shape[1]} columns")
    table = table[table[:, :3].any(axis=1)]
    table[:, :3] = table[:, :3] @ matrix[:3, :3] + matrix[3, :3]
    return table, lines[_HEADER_LINES + promised :]


def _numbers(lines: list[bytes]) -> NDArray[np.float64]:
    return np.loadtxt(lines, ndmin=2, comments=None, encoding="latin1")
