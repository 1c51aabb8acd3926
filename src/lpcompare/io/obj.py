"""Wavefront OBJ, read line by line, so that every vertex and every digit survives.

MeshLab's reader stores colours in eight bits and rounds them twice; here kept lines are the file's own.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.checks import checked_points
from lpcompare.io.polygons import fan_triangles
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"normals", "colors", "faces"})

_PER_VERTEX = (b"v", b"vn", b"vt")
_OF_THE_SURFACE = (b"f", b"l", b"p", b"s", b"g", b"o", b"usemtl", b"mtllib")


def read(path: Path) -> PointCloud:
    """Vertices with their colours, normals where there is one for each vertex, polygons as triangles."""
    lines = _lines(path)
    vertices = _table([line for word, line in lines if word == b"v"])
    if not vertices.size:
        raise ValueError("it has no vertex lines ('v x y z')")
    points = checked_points(vertices[:, :3], path.name)
    normals = _table([line for word, line in lines if word == b"vn"])
    return PointCloud(
        points,
        normals=normals[:, :3] if len(normals) == len(points) else None,
        colors=_colors(vertices),
        faces=fan_triangles(_polygons(lines), len(points), path.name),
        name=path.stem,
    )


def write(path: Path, cloud: PointCloud) -> None:
    """Each vertex with all its digits, its normal before it and its colour behind it, as MeshLab does."""
    parts = [cloud.points] if cloud.colors is None else [cloud.points, cloud.colors[:, :3]]
    with path.open("w", encoding="ascii") as file:
        for i, row in enumerate(np.column_stack(parts).tolist()):
            if cloud.normals is not None:
                file.write(f"vn {' '.join(map(repr, cloud.normals[i].tolist()))}\n")
            file.write(f"v {' '.join(map(repr, row))}\n")
        for corners in () if cloud.faces is None else (cloud.faces + 1).tolist():
            file.write(f"f {' '.join(map(str, corners))}\n")


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same lines without those of the other vertices and of the surface.

    Normals and texture coordinates stay where the file has exactly one for each vertex.
    """
    lines = _lines(source)
    counts = {w: sum(word == w for word, _ in lines) for w in _PER_VERTEX}
    kept = np.zeros(counts[b"v"], dtype=bool)
    kept[rows] = True
    seen = dict.fromkeys(_PER_VERTEX, 0)
    with target.open("wb") as file:
        for word, line in lines:
            if word in seen:
                row, seen[word] = seen[word], seen[word] + 1
                if counts[word] == len(kept) and kept[row]:
                    file.write(line + b"\n")
            elif word not in _OF_THE_SURFACE:
                file.write(line + b"\n")


def _lines(path: Path) -> list[tuple[bytes, bytes]]:
    """Each line with its first word; continued lines are joined."""
    text = path.read_bytes().replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    return [(line.split(None, 1)[0] if line.strip() else b"", line) for line in text.splitlines()]


def _table(lines: list[bytes]) -> NDArray[np.float64]:
    """The numbers that every one of like lines has, shape (n, columns)."""
    if not lines:
        return np.empty((0, 3))
    widths = [len(line.partition(b"#")[0].split()) for line in lines]
    width = min(widths)
    if width < 4:
        raise ValueError(f"the line {lines[widths.index(width)][:40]!r} has fewer than three numbers")
    return np.loadtxt(lines, usecols=range(1, width), ndmin=2, encoding="latin1")


def _colors(vertices: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Red, green, blue, alpha of rows 'x y z r g b'; None without them."""
    if vertices.shape[1] < 6:
        return None
    return np.column_stack([vertices[:, 3:6], np.ones(len(vertices))])


def _polygons(lines: list[tuple[bytes, bytes]]) -> list[list[int]]:
    """Corners of each face, counted from 0; a negative corner counts back from the vertices so far."""
    polygons: list[list[int]] = []
    n_vertices = 0
    for word, line in lines:
        if word == b"v":
            n_vertices += 1
        elif word == b"f":
            corners = [int(c.partition(b"/")[0]) for c in line.partition(b"#")[0].split()[1:]]
            polygons.append([c - 1 if c > 0 else n_vertices + c if c < 0 else -1 for c in corners])
    return polygons
