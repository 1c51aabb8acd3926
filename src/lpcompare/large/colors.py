"""Colors of tiles: tiles that see each other get different ones, so that they never work at the same time."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices, Mask


def coloring(touching: Mask) -> Indices:
    """The first free color of each tile, in order of their numbers.

    Parameters
    ----------
    touching : ndarray of bool, shape (t, t)
        Symmetric.

    Returns
    -------
    ndarray of int, shape (t,)

    Examples
    --------
    >>> import numpy as np
    >>> coloring(np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], dtype=bool))
    array([0, 1, 0])
    """
    colors = np.full(len(touching), -1)
    for tile, row in enumerate(touching):
        taken = set(colors[row].tolist())
        colors[tile] = next(color for color in range(len(touching)) if color not in taken)
    return colors


def earlier(touching: Mask) -> dict[int, list[int]]:
    """The tiles around each tile whose color comes before its own."""
    colors = coloring(touching)
    return {t: np.flatnonzero(row & (colors < colors[t])).tolist() for t, row in enumerate(touching)}
