"""Points in cubes as wide as a reach, so that all neighbors of a point lie in the 27 cubes around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Indices, Points

_MOST_CELLS = 2**20


@dataclass(frozen=True, eq=False)
class CellGrid:
    """The occupied cubes, their points, and which lie side by side.

    Attributes
    ----------
    order : ndarray of int, shape (n,)
        The points sorted by cube.
    cells : ndarray of int, shape (n,)
        Number of the cube of each point, in that order.
    starts : ndarray of int, shape (c + 1,)
        Where each occupied cube's points begin in that order.
    around : ndarray of int, shape (c, 27)
        The occupied cubes around each one, itself among them; -1 where there is none.
    """

    order: Indices
    cells: Indices
    starts: Indices
    around: NDArray[np.intp]

    @classmethod
    def over(cls, points: Points, reach: float) -> CellGrid:
        """Lay the grid; one far outlier may make the cubes wider than the reach."""
        low = points.min(axis=0)
        side = max(reach, float(np.ptp(points, axis=0).max()) / _MOST_CELLS) or 1.0
        cubes = ((points - low) / side).astype(np.int64) + 1
        _, along_y, along_z = cubes.max(axis=0) + 2
        strides = np.array([along_y * along_z, along_z, 1])
        keys = cubes @ strides
        order = np.argsort(keys, kind="stable")
        occupied, starts, cells = np.unique(keys[order], return_index=True, return_inverse=True)
        steps = np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(27, 3) @ strides
        wanted = occupied[:, None] + steps
        around = np.minimum(np.searchsorted(occupied, wanted), len(occupied) - 1)
        around[occupied[around] != wanted] = -1
        return cls(order, cells, np.append(starts, len(points)), around)
