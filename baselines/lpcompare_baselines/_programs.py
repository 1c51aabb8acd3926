"""Programs that thin a file: PLY in, PLY out, in a folder of their own."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plyfile import PlyData

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points

MOST_CALLS = 20
"""Calls of a search: each starts the program."""

_PLY_NAMES = {"f4": "float", "f8": "double", "i4": "int"}


def numbered(points: Points, kind: str, rows: Iterable[tuple[str, str, NDArray[Any]]]) -> NDArray[Any]:
    """A table for `through_program`: a cloud about the centre of its bounding box, and what says its rows.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    kind : str
        Of the fields x, y and z.
    rows : iterable of (str, str, ndarray)
        Name, kind and values (n,) of each further field.
    """
    axes = zip("xyz", (kind,) * 3, about_center(points).T, strict=True)
    names, kinds, columns = zip(*axes, *rows, strict=True)
    table = np.empty(len(points), dtype=list(zip(names, kinds, strict=True)))
    for name, column in zip(names, columns, strict=True):
        table[name] = column
    return table


def through_program(table: NDArray[Any], words: Sequence[str], **environment: str) -> NDArray[Any]:
    """What a command makes of a table: it reads in.ply and writes out.ply, both in its folder.

    Parameters
    ----------
    table : structured ndarray, shape (n,)
        The vertices of in.ply; fields of ``<f4``, ``<f8`` or ``<i4``.
    words : sequence of str
        The command.
    **environment : str
        Variables that it gets beside those of this process.

    Returns
    -------
    structured ndarray, shape (m,)
        The vertices of out.ply.

    Raises
    ------
    subprocess.CalledProcessError
        The command ended with an error.
    """
    kinds = {name: _PLY_NAMES[table.dtype[name].str[1:]] for name in table.dtype.names or ()}
    properties = "".join(f"property {kind} {name}\n" for name, kind in kinds.items())
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(table)}\n{properties}end_header\n"
    with TemporaryDirectory() as folder:
        (Path(folder) / "in.ply").write_bytes(head.encode() + table.tobytes())
        subprocess.run(words, cwd=folder, env=os.environ | environment, capture_output=True, check=True)
        file = PlyData.read(Path(folder) / "out.ply", mmap=False)  # pyright: ignore[reportArgumentType]
        return np.array(file["vertex"].data)
