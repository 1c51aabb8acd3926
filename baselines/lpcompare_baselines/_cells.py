"""Regular grids of cells over a cloud."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Points


def finest_cell(points: Points) -> float:
    """The smallest size whose cells can be numbered: a two-millionth of the box's longest side."""
    return float(np.ptp(points, axis=0).max()) / 2**21


def grid_cells(points: Points, size: float) -> NDArray[np.int64]:
    """Cell of each point, shape (n,), in a grid of cubes that begins at the low corner of the bounding box.

    Cells are numbered; sizes below `finest_cell` are taken as that.
    """
    low, size = points.min(axis=0), max(size, finest_cell(points))
    cells = ((points - low) / size).astype(np.int64)
    return _numbered(cells, cells.max(axis=0) + 1)


def meshlab_cells(points: Points, size: float) -> NDArray[np.int64]:
    """Cell of each point, shape (n,), in the grid that MeshLab's clustering filters lay.

    The box, grown by a cell on each side, is cut into a whole number of cells per axis, none below ``size``.
    """
    size = float(np.float32(size))
    low, high = points.min(axis=0) - size, points.max(axis=0) + size
    n_cells = ((high - low) / size).astype(np.int64)
    return _numbered(((points - low) / ((high - low) / n_cells)).astype(np.int64), n_cells)


def n_occupied(cells: NDArray[np.int64]) -> int:
    """How many distinct cells there are."""
    return int(np.count_nonzero(np.diff(np.sort(cells)))) + 1


def cell_means(points: Points, cells: NDArray[np.int64]) -> tuple[Points, NDArray[np.intp]]:
    """Mean of the points of each occupied cell, shape (m, 3), and the mean that each point went into."""
    _, group = np.unique(cells, return_inverse=True)
    n_in = np.bincount(group)
    sums = np.column_stack([np.bincount(group, weights=column) for column in points.T])
    return sums / n_in[:, None], group


def _numbered(cells: NDArray[np.int64], n_cells: NDArray[np.int64]) -> NDArray[np.int64]:
    x, y, z = cells.T
    return (x * n_cells[1] + y) * n_cells[2] + z
