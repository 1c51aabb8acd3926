"""Colors of tiles: tiles that see each other get different ones, so that they never work at the same time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lpcompare.types import Indices


def coloring(touching: Sequence[Indices]) -> Indices:
    """The first free color of each tile, in order of their numbers.

    Parameters
    ----------
    touching : sequence of ndarray of int
        The tiles that each tile sees, and that see it.

    Returns
    -------
    ndarray of int, shape (t,)

    Examples
    --------
    >>> import numpy as np
    >>> coloring([np.array([1]), np.array([0, 2]), np.array([1])])
    array([0, 1, 0])
    """
    colors = np.full(len(touching), -1)
    for tile, others in enumerate(touching):
        taken = set(colors[others].tolist())
        colors[tile] = next(color for color in range(len(taken) + 1) if color not in taken)
    return colors


def earlier(touching: Sequence[Indices], colors: Indices) -> list[Indices]:
    """The tiles around each tile whose color comes before its own."""
    return [others[colors[others] < colors[tile]] for tile, others in enumerate(touching)]
