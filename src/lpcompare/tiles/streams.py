"""What a format must offer to be read and written in parts, and which file offers it.

A module of this protocol has ``count_points(path)``, ``note_on(path)``, ``read_rows(path, start, stop)`` and
``writer(path, source, count)``. Rows that were read from one file can be appended to a writer of another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from lpcompare.errors import InputError, LpcompareError
from lpcompare.files import CONTINUE, whole_file
from lpcompare.io.rows import Damaged
from lpcompare.types import Points

Append = Callable[[Path, Any], None]
"""Called with the file that some records come from, and the records."""

STREAMS = {
    ".las": "las_stream",
    ".laz": "las_stream",
    ".ply": "record_stream",
    ".pcd": "record_stream",
    ".npy": "record_stream",
}


def stream(path: Path) -> ModuleType:
    """The module that reads and writes a file in parts.

    Raises
    ------
    InputError
        The format is not one that can be read in parts.
    """
    if path.suffix.lower() not in STREAMS:
        raise InputError(
            f"{path} has the ending {path.suffix!r}, which is not read in parts; "
            f"convert it to one of {', '.join(STREAMS)}."
        )
    return import_module(f"lpcompare.tiles.{STREAMS[path.suffix.lower()]}")


def count_points(path: Path) -> int:
    """Points of a file; raises `InputError` with one sentence where it cannot be read."""
    with _sentences(path):
        return stream(path).count_points(path)


def note_on(path: Path) -> str:
    """What a copy of some of the points of a file leaves out."""
    return stream(path).note_on(path)


def read_rows(path: Path, start: int, stop: int) -> tuple[Points, Any]:
    """Coordinates (m, 3) and records (m,) of some points of a file; raises `InputError`."""
    with _sentences(path):
        return stream(path).read_rows(path, start, stop)


@contextmanager
def writer(path: Path, source: Path, count: int) -> Iterator[Append]:
    """What appends records to a file of the format of ``source``, which appears when it is complete."""
    with (
        whole_file(path, CONTINUE) as part,
        _sentences(path),
        stream(path).writer(part, source, count) as append,
    ):
        yield append


@contextmanager
def _sentences(path: Path) -> Iterator[None]:
    try:
        yield
    except (LpcompareError, OSError):
        raise
    except Damaged as error:
        raise InputError(f"{path}: {error}.") from error
    except Exception as error:
        raise InputError(f"{path} is damaged, or not of its format ({type(error).__name__}).") from error
