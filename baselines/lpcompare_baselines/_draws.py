"""Repeatable draws from MeshLab's random filters, and the one of them that has the count asked for.

MeshLab has one random generator per process and no way to seed it, and on clouds below some 20,000 points its
Poisson disk does not even ask it. But every draw depends on the order of the points: an order drawn from a
seed takes the place of MeshLab's own. Larger clouds need a fresh process beside it.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from lpcompare.types import Indices, Points
from lpcompare_baselines._calibration import search_size
from lpcompare_baselines._guards import check_distinct, check_resolved
from lpcompare_baselines._meshlab import finest_length, mesh_set, rows_of

_LARGEST_SEED = 2**31
_EXACT_UP_TO = 20_000
"""Points up to which the count itself is searched; beyond, one in so many may be missed."""
_FEWEST_CALLS, _MOST_CALLS = 24, 60
_POINTS_PER_SEARCH = 3_000_000
"""Points that all draws of a search may look at together, within those calls."""


class Draw(NamedTuple):
    """A sample that can be taken again in the same state of the process."""

    size: float
    order_seed: int


def drawn_rows(points: Points, order_seed: int, thin: Callable[[Any], object]) -> Indices:
    """Rows that a filter keeps of a layer whose points are in the order that a seed gives, ascending."""
    order = np.random.default_rng(order_seed).permutation(len(points))
    meshes = mesh_set(points[order])
    thin(meshes)
    return np.sort(order[rows_of(meshes)])


def search_draw(
    sample: Callable[[float, int], Indices],
    points: Points,
    target_count: int,
    start: float,
    rng: np.random.Generator,
    *,
    smallest: float = 0.0,
) -> Draw:
    """The draw whose count is nearest to the target.

    Counts scatter from draw to draw, so each probe takes another order of the points.

    Parameters
    ----------
    sample : callable
        Rows that a size and a seed for the order of the points give.
    points : ndarray, shape (n, 3)
    target_count : int
    start : float
        The first size tried.
    rng : numpy.random.Generator
        Draws the first seed.
    smallest : float, optional
        The smallest size that is tried.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """
    check_distinct(points, target_count)
    check_resolved(points, target_count, finest_length(points))
    first, tried = int(rng.integers(_LARGEST_SEED)), list[tuple[int, Draw]]()
    max_calls = int(np.clip(_POINTS_PER_SEARCH // len(points), _FEWEST_CALLS, _MOST_CALLS))

    def count(size: float) -> int:
        draw = Draw(size, first + len(tried))
        n = _foresee(lambda: len(sample(*draw)))
        tried.append((abs(n - target_count), draw))
        return n

    tolerance = target_count // _EXACT_UP_TO
    search_size(count, target_count, start, smallest=smallest, tolerance=tolerance, max_calls=max_calls)
    return min(tried)[1]


def _foresee(count: Callable[[], int]) -> int:
    """What ``count`` would return, asked of a copy of this process: MeshLab's generator stays where it is.

    Where a process cannot be forked with safety (only Linux can), ``count`` is called here, and the next draw
    differs from it by the scatter.
    """
    if sys.platform != "linux":
        return count()
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        # the copy calls one filter, which takes no lock of another thread
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        try:
            os.write(writer, str(count()).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as answers:
        answer = answers.read()
    os.waitpid(child, 0)
    if not answer:
        raise RuntimeError("MeshLab's filter ended its process while the count was searched.")
    return int(answer)
