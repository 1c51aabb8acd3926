"""CloudCompare's octree subsampling, by its command line: of each occupied cell, the point nearest its centre.

Only the counts of whole levels can be had, each about four times the one before; the level whose count is
nearest to the target is searched outside the clock. The call includes starting the program and going through
files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._cloudcompare import subsample

TRAITS = Traits(
    wraps="CloudCompare -SS OCTREE",
    source="CloudCompare, https://www.cloudcompare.org",
    licence="GPL-2.0-or-later",
    family="voxel",
    exact_count=False,
    programs=("CloudCompare",),
    install="apt install cloudcompare, or from https://www.cloudcompare.org",
)

_DEEPEST = 10
"""Deepest level in CloudCompare's builds with 32-bit cell codes."""


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, int]:
    """The level, from 1 to 10, whose count is nearest to ``target_count``."""
    counts = dict[int, int]()
    for level in range(1, _DEEPEST + 1):
        counts[level] = len(subsample(points, "OCTREE", level))
        if counts[level] >= target_count:
            break
    return {"level": min(counts, key=lambda level: abs(counts[level] - target_count))}


def cloudcompare_octree(
    points: Points, target_count: int, *, rng: np.random.Generator, level: int
) -> Simplification:
    """Keep one point of each occupied cell.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    level : int
        Level of the octree: the cells' edge is the bounding cube's divided by 2^level.

    Returns
    -------
    Simplification
        A subset of the input, as many points as cells are occupied.
    """
    indices = subsample(points, "OCTREE", level)
    return Simplification(points[indices], indices)
