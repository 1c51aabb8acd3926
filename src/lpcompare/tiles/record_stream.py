"""Binary PLY, binary PCD and NPY in parts: points are records of one size behind a header."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.io import pcd, ply
from lpcompare.io.columns import find_roles
from lpcompare.io.rows import LONGEST_HEADER, Damaged, check_room
from lpcompare.tiles.streams import Append
from lpcompare.types import Points


@dataclass(frozen=True)
class _Layout:
    """Where the records are, what they are, which three fields are coordinates, and the header of a copy."""

    count: int
    start: int
    kind: np.dtype[Any]
    axes: tuple[str, ...]
    head: Callable[[int], bytes]
    note: str = ""
    viewpoint: tuple[float, ...] = ()


def count_points(path: Path) -> int:
    """How many points the header promises; raises `Damaged` where the file cannot hold them."""
    return _layout(path).count


def note_on(path: Path) -> str:
    """What a copy of some of the points leaves out."""
    return _layout(path).note


def read_rows(path: Path, start: int, stop: int) -> tuple[Points, NDArray[Any]]:
    """Coordinates of the points ``start`` to ``stop``, and their records."""
    layout = _layout(path)
    with path.open("rb") as file:
        file.seek(layout.start + start * layout.kind.itemsize)
        table = np.fromfile(file, layout.kind, stop - start)
    if not layout.axes:
        return table[:, :3].astype(np.float64), table
    return np.column_stack([table[name] for name in layout.axes]).astype(np.float64), table


@contextmanager
def writer(path: Path, source: Path, count: int) -> Iterator[Append]:
    """Write the header of ``source`` for ``count`` points; records are appended."""
    layout = _layout(source)
    with path.open("wb") as file:
        file.write(layout.head(count))

        def append(other: Path, records: NDArray[Any]) -> None:
            if np.dtype((records.dtype, records.shape[1:])) != layout.kind:
                raise Damaged(f"{other.name} has other properties than {source.name}")
            if other != source and _layout(other).viewpoint != layout.viewpoint:
                raise Damaged(
                    f"{other.name} has another viewpoint than {source.name}; write to a folder instead"
                )
            file.write(records.tobytes())

        yield append


def _layout(path: Path) -> _Layout:
    with path.open("rb") as file:
        content = file.read(LONGEST_HEADER)
    layout = {".ply": _ply, ".pcd": _pcd, ".npy": _npy}[path.suffix.lower()](path, content)
    check_room("points", layout.count, layout.kind.itemsize, path.stat().st_size - layout.start)
    return layout


def _ply(_: Path, content: bytes) -> _Layout:
    order, head, elements, start = ply.parse_header(content)
    if not order:
        raise Damaged("it is a text file, which is not read in parts; convert it to binary")
    if not elements or elements[0].name != "vertex" or any(count for *_, count in elements[0].properties):
        raise Damaged("its first element is not 'vertex' with numbers alone, so it is not read in parts")
    vertex = elements[0]
    kind = np.dtype([(name, order + kind) for name, kind, _ in vertex.properties])
    others = {i for element in elements[1:] for i in element.lines}
    lines = [line for i, line in enumerate(head) if i not in others]
    at = vertex.lines[0]

    def copy(count: int) -> bytes:
        return b"".join([*lines[:at], re.sub(rb"\d+(?=\s*$)", b"%d" % count, lines[at]), *lines[at + 1 :]])

    lost = ", ".join(element.name for element in elements[1:] if element.count)
    return _Layout(
        vertex.count, start, kind, _axes(list(kind.names or ())), copy, f"{lost} left out" if lost else ""
    )


def _pcd(_: Path, content: bytes) -> _Layout:
    file = pcd.parse_header(content)
    if file.encoding != b"binary":
        raise Damaged(
            f"its encoding is {file.encoding.decode('latin1')!r}; only 'binary' is read in parts, convert it"
        )
    axes = dict(zip(file.names, file.kind.names or (), strict=True))
    start = len(content) - len(file.body)

    def copy(count: int) -> bytes:
        return pcd.head_of(file.head, count) + b"DATA binary\n"

    names = tuple(axes[name] for name in _axes(list(axes)))
    return _Layout(file.count, start, file.kind, names, copy, viewpoint=pcd.viewpoint(file.head))


def _npy(path: Path, _: bytes) -> _Layout:
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except ValueError as error:
        raise Damaged("it is no array of numbers") from error
    if array.ndim != 2 or array.shape[1] < 3 or not array.flags.c_contiguous or array.dtype.kind not in "iuf":
        raise Damaged(f"its array has the shape {array.shape}; points have the shape (n, 3), row after row")
    kind, width = array.dtype, array.shape[1]

    def copy(count: int) -> bytes:
        from io import BytesIO

        head = BytesIO()
        names = {"descr": np.lib.format.dtype_to_descr(kind), "fortran_order": False, "shape": (count, width)}
        np.lib.format.write_array_header_1_0(head, names)
        return head.getvalue()

    start = path.stat().st_size - array.size * kind.itemsize
    return _Layout(len(array), start, np.dtype((kind, (width,))), (), copy)


def _axes(names: list[str]) -> tuple[str, ...]:
    roles = find_roles(names)
    if "points" not in roles:
        raise Damaged(f"none of its columns are named x, y and z, only {', '.join(names[:20])}")
    return roles["points"]
