"""Regular grids of cells over a cloud."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Points


def meshlab_cells(points: Points, size: float) -> NDArray[np.int64]:
    """Number of the cell of each point, shape (n,), in the grid of MeshLab's clustering filters.

    The box, grown by a cell on each side, is divided into a whole number of cells per axis, none below ``size``.
    """
    size = float(np.float32(size))
    low, high = points.min(axis=0) - size, points.max(axis=0) + size
    n_cells = ((high - low) / size).astype(np.int64)
    return _numbered(((points - low) / ((high - low) / n_cells)).astype(np.int64), n_cells)


def _numbered(cells: NDArray[np.int64], n_cells: NDArray[np.int64]) -> NDArray[np.int64]:
    x, y, z = cells.T
    return (x * n_cells[1] + y) * n_cells[2] + z


def n_occupied(numbers: NDArray[np.int64]) -> int:
    """How many distinct cells there are."""
    return int(np.count_nonzero(np.diff(np.sort(numbers)))) + 1
