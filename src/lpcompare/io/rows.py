"""Rows of text as numbers, and what is said of a file that does not keep to its format."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

LONGEST_HEADER = 2**20


class Damaged(ValueError):  # noqa: N818 - it is a state of the file
    """A file that does not keep to its format; the text is part of a sentence about it."""


def check_held(what: str, promised: int, held: int) -> None:
    """Raise `Damaged` where a file promises more of something than it has."""
    if promised > held:
        raise Damaged(f"it promises {promised} {what} and holds {max(held, 0)}; is the file complete?")


def check_room(what: str, promised: int, length: int, room: int) -> None:
    """Raise `Damaged` where things of ``length`` bytes do not fit into ``room`` bytes."""
    check_held(what, promised, room // length if length else 0)


def numbers(
    lines: Sequence[bytes], dtype: DTypeLike = np.float64, separator: str | None = None, **how: Any
) -> NDArray[Any]:
    """The numbers of lines that have equally many, shape (n, columns); raises `Damaged` at any other line.

    Parameters
    ----------
    lines : sequence of bytes
    dtype : data type
        One of several fields gives a structured array of shape (n,).
    separator : str or None
        None is white space.
    **how
        Of `numpy.loadtxt`.
    """
    table = np.dtype(dtype)
    if not len(lines):
        return np.empty((0, 0) if table.names is None else 0, table)
    how = {"comments": None, "encoding": "latin1", "ndmin": 2 if table.names is None else 1} | how
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return np.loadtxt(lines, table, delimiter=separator, **how)
    except (ValueError, UserWarning, DeprecationWarning, OverflowError) as error:
        row = re.search(r"row (\d+)", str(error))
        at = int(row[1]) - ("columns" in str(error)) if row else 0  # counted from 1 where it is about columns
        line = lines[min(at, len(lines) - 1)]
        raise Damaged(f"{line.strip()[:40]!r} is not the row of numbers that is needed") from error


def decoded(text: bytes) -> str:
    """Text of UTF-8, or of Latin-1 where it is not that."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")
