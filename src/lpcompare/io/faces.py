"""Faces of any number of sides, and triangle strips, as triangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.io.rows import Damaged


def fan_triangles(polygons: Sequence[Sequence[int]] | NDArray[Any], n_points: int) -> NDArray[np.intp] | None:
    """Each polygon as the fan of triangles around its first corner.

    Parameters
    ----------
    polygons : sequence of sequences of int
        Corners as rows of the points. Polygons of fewer than three corners span nothing and are left out.
    n_points : int
        Corners outside 0 .. n_points - 1 are `Damaged`.

    Returns
    -------
    ndarray of int, shape (f, 3), or None where no triangle remains.
    """
    sizes = np.fromiter(map(len, polygons), dtype=np.intp, count=len(polygons))
    if sizes.sum() == 0:
        return None
    corners = np.concatenate(polygons).astype(np.intp)
    n_triangles = np.maximum(sizes - 2, 0)
    first = np.repeat(np.cumsum(sizes) - sizes, n_triangles)
    step = np.arange(n_triangles.sum()) - np.repeat(np.cumsum(n_triangles) - n_triangles, n_triangles)
    triangles = corners[np.column_stack([first, first + step + 1, first + step + 2])]
    return checked_triangles(triangles, n_points)


def strip_triangles(strips: Sequence[NDArray[Any]] | NDArray[Any], n_points: int) -> NDArray[np.intp] | None:
    """Triangles of strips, in which -1 begins a new one; every second one of a strip is turned around.

    Parameters
    ----------
    strips : sequence of ndarrays of int
    n_points : int
        As for `fan_triangles`.
    """
    corners = np.concatenate([np.append(strip, -1) for strip in strips]).astype(np.intp)
    if len(corners) < 3:
        return None
    triangles = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    position = np.arange(len(corners))
    start = np.maximum.accumulate(np.where(corners < 0, position + 1, 0))[:-2]
    odd = (position[:-2] - start) % 2 == 1
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    a, b, c = triangles.T
    return checked_triangles(triangles[(triangles >= 0).all(1) & (a != b) & (b != c) & (a != c)], n_points)


def checked_triangles(triangles: NDArray[np.intp], n_points: int) -> NDArray[np.intp] | None:
    """The triangles, or None if there are none; `Damaged` if a corner is no point."""
    wrong = (triangles < 0) | (triangles >= n_points)
    if wrong.any():
        named = int(triangles[wrong][0])
        raise Damaged(f"a face names point {named}, but the points are 0 to {n_points - 1}")
    return triangles if len(triangles) else None
