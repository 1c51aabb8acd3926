"""OFF and its kin with colours and normals (COFF, NOFF, ...), in text; kept lines are the file's own."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lpcompare.io.checks import checked_points
from lpcompare.io.polygons import fan_triangles
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"colors", "faces"})

_KEYWORD = re.compile(rb"(ST)?[CN]{0,2}4?n?OFF\b")


@dataclass(frozen=True)
class _File:
    """An OFF file taken apart: its keyword, comments, vertex lines and face lines."""

    keyword: bytes
    comments: list[bytes]
    vertices: list[bytes]
    faces: list[bytes]


def read(path: Path) -> PointCloud:
    """Vertices and triangles; colours or normals where the keyword leaves no doubt about the columns."""
    file = _take_apart(path)
    values = np.loadtxt(file.vertices, ndmin=2, comments=None, encoding="latin1")
    points = checked_points(values[:, :3], path.name)
    corners = [[int(c) for c in line.split()] for line in file.faces]
    for line in corners:
        if len(line) <= line[0]:
            raise ValueError(f"a face of {line[0]} corners names {len(line) - 1}")
    faces = fan_triangles([line[1 : 1 + line[0]] for line in corners], len(points), path.name)
    if file.keyword == b"NOFF" and values.shape[1] == 6:
        return PointCloud(points, normals=values[:, 3:6], faces=faces, name=path.stem)
    if file.keyword == b"COFF" and values.shape[1] in (6, 7):
        return PointCloud(points, colors=_colors(values[:, 3:]), faces=faces, name=path.stem)
    more = {f"column_{i + 1}": values[:, i] for i in range(3, values.shape[1])}
    return PointCloud(points, attributes=more, faces=faces, name=path.stem)


def write(path: Path, cloud: PointCloud) -> None:
    """OFF, or COFF with colours as bytes; coordinates with all their digits."""
    colors = None if cloud.colors is None else np.rint(np.clip(cloud.colors, 0, 1) * 255).astype(int).tolist()
    faces = [] if cloud.faces is None else cloud.faces.tolist()
    with path.open("w", encoding="ascii") as file:
        file.write(f"{'OFF' if colors is None else 'COFF'}\n{len(cloud)} {len(faces)} 0\n")
        for i, point in enumerate(cloud.points.tolist()):
            file.write(" ".join(map(repr, point)))
            file.write("\n" if colors is None else f" {' '.join(map(str, colors[i]))}\n")
        file.writelines(f"3 {' '.join(map(str, corners))}\n" for corners in faces)


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same comments and vertex lines, without faces."""
    file = _take_apart(source)
    head = [file.keyword, *file.comments, b"%d 0 0" % len(rows)]
    target.write_bytes(b"\n".join([*head, *(file.vertices[i] for i in rows)]) + b"\n")


def _take_apart(path: Path) -> _File:
    """Split the file by its counts.

    Raises
    ------
    ValueError
        No OFF keyword, a binary or four-dimensional file, or fewer lines than the counts say.
    """
    lines = [line.strip() for line in path.read_bytes().splitlines()]
    comments = [line for line in lines if line.startswith(b"#")]
    content = [line.partition(b"#")[0].strip() for line in lines]
    content = [line for line in content if line]
    match = _KEYWORD.match(content[0]) if content else None
    if match is None:
        raise ValueError("it does not begin with OFF")
    keyword, after = match[0], content[0][match.end() :].split()
    if b"4" in keyword or b"n" in keyword or after[:1] == [b"BINARY"]:
        raise ValueError(f"the kind {content[0][:20]!r} is not supported, only text in three dimensions")
    counts = after or content[1].split()
    body = content[1:] if after else content[2:]
    n_vertices, n_faces = int(counts[0]), int(counts[1])
    if n_vertices < 1 or n_faces < 0 or len(body) < n_vertices + n_faces:
        raise ValueError(f"it promises {n_vertices} vertices and {n_faces} faces and holds {len(body)} lines")
    return _File(keyword, comments, body[:n_vertices], body[n_vertices : n_vertices + n_faces])


def _colors(values: np.ndarray) -> np.ndarray:
    """Colours from 0 to 1: written as fractions, or as bytes where a value is larger than 1."""
    scaled = values / 255 if values.max() > 1 else values
    return scaled if values.shape[1] == 4 else np.column_stack([scaled, np.ones(len(scaled))])
