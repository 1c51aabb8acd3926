"""OFF and its kin with colours and normals (COFF, NOFF, ...), in text; kept lines are the file's own."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from lpcompare.io.columns import AXES, COLORS, NORMALS, Holds, cloud_of, with_bytes
from lpcompare.io.faces import fan_triangles
from lpcompare.io.rows import Damaged, numbers
from lpcompare.types import Indices, PointCloud

HOLDS = {".off": Holds(colors="u1", faces=True)}

_KEYWORD = re.compile(rb"(ST)?[CN]{0,2}4?n?OFF\b")


@dataclass(frozen=True)
class _File:
    """An OFF file taken apart: its keyword, comments, vertex lines and face lines."""

    keyword: bytes
    comments: list[bytes]
    vertices: list[bytes]
    faces: list[bytes]


def read(path: Path) -> PointCloud:
    """Vertices and triangles; colours and normals where the keyword leaves no doubt about the columns.

    Whole numbers are colours from 0 to 255, others fractions, as Geomview's description says.
    """
    file = _take_apart(path)
    values = numbers(file.vertices)
    corners = _polygons(file.faces)
    faces = fan_triangles(corners, len(values)) if corners else None
    columns = dict(zip(_names(file.keyword, values.shape[1]), values.T, strict=True))
    n_channels = sum(name in COLORS for name in columns)
    channels = b"".join(word for line in file.vertices for word in line.split()[-n_channels:])
    return cloud_of(with_bytes(columns) if channels.isdigit() else columns, path.stem, faces)


def write(path: Path, cloud: PointCloud) -> None:
    """OFF, or COFF with colours as bytes; coordinates with all their digits."""
    colors = None if cloud.colors is None else cloud.colors.tolist()
    faces = [] if cloud.faces is None else cloud.faces.tolist()
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(f"{'OFF' if colors is None else 'COFF'}\n{len(cloud)} {len(faces)} 0\n")
        for i, point in enumerate(cloud.points.tolist()):
            file.write(" ".join(map(repr, point)))
            file.write("\n" if colors is None else f" {' '.join(map(str, colors[i]))}\n")
        file.writelines(f"3 {' '.join(map(str, corners))}\n" for corners in faces)


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same comments and vertex lines, without faces."""
    file = _take_apart(source)
    head = [file.keyword, *file.comments, b"%d 0 0" % len(rows)]
    target.write_bytes(b"\n".join([*head, *(file.vertices[i] for i in rows)]) + b"\n")
    return ()


def _take_apart(path: Path) -> _File:
    """Split the file by its counts.

    Raises
    ------
    Damaged
        No OFF keyword, a binary or four-dimensional file, or another number of lines than the counts say.
    """
    lines = [line.strip() for line in path.read_bytes().splitlines()]
    comments = [line for line in lines if line.startswith(b"#")]
    content = [line.partition(b"#")[0].strip() for line in lines]
    content = [line for line in content if line]
    match = _KEYWORD.match(content[0]) if content else None
    if match is None and not re.fullmatch(rb"\d+ +\d+( +\d+)?", content[0] if content else b""):
        raise Damaged("it does not begin with OFF")
    keyword, after = (match[0], content[0][match.end() :].split()) if match else (b"OFF", content[0].split())
    if b"4" in keyword or b"n" in keyword or after[:1] == [b"BINARY"]:
        raise Damaged(f"the kind {content[0][:20]!r} is not supported, only text in three dimensions")
    counts = after or b"".join(content[1:2]).split()
    body = content[1:] if after else content[2:]
    n_vertices, n_faces = (int(n) if n.isdigit() else -1 for n in (*counts, b"", b"")[:2])
    if n_vertices < 1 or n_faces < 0 or len(body) != n_vertices + n_faces:
        raise Damaged(f"it promises {n_vertices} vertices and {n_faces} faces and holds {len(body)} lines")
    return _File(keyword, comments, body[:n_vertices], body[n_vertices : n_vertices + n_faces])


def _names(keyword: bytes, width: int) -> list[str]:
    """The columns' names: normals and colours of the keyword, where they fill the row; else numbered ones."""
    names = [*AXES, *(NORMALS if b"N" in keyword else ())]
    rest = width - len(names)
    if b"C" in keyword and rest in (3, 4) and not keyword.startswith(b"ST"):
        names += COLORS[:rest]
    if len(names) != width:
        names = [*AXES, *(f"column_{i}" for i in range(4, width + 1))]
    return names[:width]


def _polygons(lines: list[bytes]) -> list[list[int]]:
    """The corners of each line 'n a b c ... color'."""
    polygons = []
    for line in lines:
        n, *corners = (word for word in line.split())
        if not n.isdigit() or int(n) > len(corners) or not all(c.isdigit() for c in corners[: int(n)]):
            raise Damaged(f"{line[:40]!r} is no face: a number of corners, and so many rows of points")
        polygons.append([int(corner) for corner in corners[: int(n)]])
    return polygons
