"""Wavefront OBJ, read line by line, so that every vertex and every digit survives.

MeshLab's reader stores colours in eight bits and rounds them twice; here kept lines are the file's own. Other
files that it names, such as materials, are not opened.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.columns import Holds, fractions
from lpcompare.io.faces import fan_triangles
from lpcompare.io.rows import Damaged, numbers
from lpcompare.types import Indices, PointCloud

HOLDS = {".obj": Holds(normals="f8", colors="f8", alpha=False, faces=True)}

_OF_THE_SURFACE = (b"f", b"l", b"p", b"s", b"g", b"o", b"usemtl", b"mtllib")
_PER_VERTEX = {b"vt": 1, b"vn": 2}  # which number of a corner 'vertex/texture/normal' names it


@dataclass(frozen=True)
class _File:
    """Each line with its first word; the polygons; which texture and normal line is each vertex's own."""

    lines: list[tuple[bytes, bytes]]
    polygons: list[list[int]]
    own: dict[bytes, NDArray[np.intp] | None]

    def of(self, word: bytes) -> list[bytes]:
        """The lines that begin with a word."""
        return [line for first, line in self.lines if first == word]


def read(path: Path) -> PointCloud:
    """Vertices with their colours, normals where each vertex has one of its own, polygons as triangles."""
    file = _take_apart(path)
    vertices = _table(file.of(b"v"))
    if not vertices.size:
        raise Damaged("it has no vertex lines ('v x y z')")
    own, width = file.own[b"vn"], vertices.shape[1]
    lost = {
        "its texture coordinates": file.of(b"vt"),
        "its normals, of which points have none or several,": own is None and file.of(b"vn"),
        "further numbers of its points": width > 6 or 3 < width < 6,
    }
    return PointCloud(
        vertices[:, :3],
        normals=None if own is None else _table(file.of(b"vn"))[own, :3],
        colors=fractions(*vertices[:, 3:6].T) if width >= 6 else None,
        faces=fan_triangles(file.polygons, len(vertices)),
        name=path.stem,
        beside=tuple(name for name, there in lost.items() if there),
    )


def write(path: Path, cloud: PointCloud) -> None:
    """Each vertex with all its digits, its normal before it and its colour behind it, as MeshLab does."""
    rows = np.column_stack([cloud.points] if cloud.colors is None else [cloud.points, cloud.colors]).tolist()
    normals = None if cloud.normals is None else cloud.normals.tolist()
    with path.open("w", encoding="ascii", newline="\n") as file:
        for i, row in enumerate(rows):
            if normals is not None:
                file.write(f"vn {' '.join(map(repr, normals[i]))}\n")
            file.write(f"v {' '.join(map(repr, row))}\n")
        for corners in () if cloud.faces is None else (cloud.faces + 1).tolist():
            file.write(f"f {' '.join(map(str, corners))}\n")


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same lines without those of the other vertices and of the surface.

    A vertex's own normal and texture coordinates stay: in their place where they have its number, else
    before it.
    """
    file = _take_apart(source)
    kept, seen = set(rows.tolist()), dict.fromkeys((b"v", *_PER_VERTEX), -1)
    counted = {word: own is not None and (own == np.arange(len(own))).all() for word, own in file.own.items()}
    named = [(file.of(w), own) for w, own in file.own.items() if own is not None and not counted[w]]
    with target.open("wb") as out:
        for word, line in file.lines:
            seen[word] = seen.get(word, 0) + 1
            if word == b"v" and seen[word] in kept:
                out.writelines(lines[own[seen[word]]] + b"\n" for lines, own in named)
            if word in (b"v", *_PER_VERTEX):
                stays = counted.get(word, True) and seen[word] in kept
            else:
                stays = word not in _OF_THE_SURFACE
            if stays:
                out.write(line + b"\n")
    return ()


def _take_apart(path: Path) -> _File:
    """The lines with their first words, continued lines joined, and what the faces say."""
    text = path.read_bytes().replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    lines = [(line.split(None, 1)[0] if line.strip() else b"", line) for line in text.splitlines()]
    file = _File(lines, [], {})
    n_lines, corners = dict[bytes, int].fromkeys((b"v", *_PER_VERTEX), 0), list[list[list[bytes]]]()
    for word, line in lines:
        if word in n_lines:
            n_lines[word] += 1
        elif word == b"f":
            words = line.partition(b"#")[0].split()[1:]
            corners.append([corner.split(b"/") for corner in words])
            file.polygons.append([_row(corner[0], n_lines[b"v"]) for corner in corners[-1]])
    flat = [corner for face in corners for corner in face]
    rows = np.array([row for face in file.polygons for row in face], dtype=np.intp)
    for word, place in _PER_VERTEX.items():
        named = [_row(c[place], n_lines[word]) if len(c) > place and c[place] else -1 for c in flat]
        file.own[word] = _own(rows, np.array(named, dtype=np.intp), n_lines[b"v"], file.of(word))
    return file


def _row(number: bytes, n_lines: int) -> int:
    """What a corner names, counted from 0; a negative number counts back from the lines so far."""
    try:
        value = int(number)
    except ValueError:
        raise Damaged(f"a face has the corner {number[:40]!r}") from None
    return value - 1 if value > 0 else n_lines + value if value < 0 else -1


def _own(
    vertices: NDArray[np.intp], named: NDArray[np.intp], n_vertices: int, lines: list[bytes]
) -> NDArray[np.intp] | None:
    """The line of each vertex: its own number, or the one all its faces name; None where they differ."""
    by_number = np.arange(n_vertices)
    said = named >= 0
    if (named[said] >= len(lines)).any() or not lines or not n_vertices:
        return None
    if (vertices[said] == named[said]).all():
        return by_number if len(lines) == n_vertices else None
    first: dict[bytes, int] = {}
    same = np.array([first.setdefault(line, i) for i, line in enumerate(lines)])[named]
    own = np.full(n_vertices, -1)
    own[vertices[said]] = same[said]
    agreed = said.all() and (own >= 0).all() and (own[vertices] == same).all()
    return own if agreed else None


def _table(lines: list[bytes]) -> NDArray[np.float64]:
    """The numbers that every one of like lines has, shape (n, columns)."""
    if not lines:
        return np.empty((0, 3))
    widths = [len(line.partition(b"#")[0].split()) for line in lines]
    width = min(widths)
    if width < 4:
        raise Damaged(f"the line {lines[widths.index(width)][:40]!r} has fewer than three numbers")
    return numbers(lines, usecols=range(1, width), comments="#")
