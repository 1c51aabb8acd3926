"""One search for the radius or the cell size at which a rival returns the count asked for."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log
from typing import Any

import numpy as np

from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.types import Points
from lpcompare_baselines._guards import check_distinct, check_resolved

_NARROWEST = 1e-4
"""Relative width at which a bracket is closed."""
_FARTHEST = 1e9
"""How many times smaller or larger than the first size the others may be."""
_GOLDEN = 0.618

_Probe = tuple[float, int]


def search_size(
    count: Callable[[float], int],
    target_count: int,
    start: float,
    *,
    smallest: float = 0.0,
    tolerance: int = 0,
    max_calls: int = 60,
) -> float:
    """Size whose count is nearest to the target: a bracketing secant on the log-log scale.

    Counts of grids and of random draws are not quite monotone. When the bracket has closed on a step over the
    target, the search goes on by small corrections of uneven length: one of them often gives the target.

    Parameters
    ----------
    count : callable
        Points that a size gives: fewer for a larger size, but for small steps the wrong way.
    target_count : int
    start : float
        The first size tried, positive.
    smallest : float, optional
        The smallest size that is tried.
    tolerance : int, optional
        Points beside the target that are near enough.
    max_calls : int, optional
        Calls of ``count`` after which the nearest size so far is returned.

    Returns
    -------
    float
        The same one whenever ``count`` gives the same counts.
    """
    lower: _Probe | None = None
    upper: _Probe | None = None
    nearest: tuple[int, float] | None = None
    low, high = log(max(smallest, start / _FARTHEST)), log(start * _FARTHEST)
    x, n_closed = log(start), 0
    for call in range(max_calls):
        x = min(max(x, low), high)
        n = count(exp(x))
        nearest = min(nearest or (abs(n - target_count), x), (abs(n - target_count), x))
        if nearest[0] <= tolerance:
            break
        lower, upper = ((x, n), upper) if n > target_count else (lower, (x, n))
        if n_closed or (lower and upper and upper[0] - lower[0] < _NARROWEST):
            n_closed += 1
            x += (0.05 + 0.25 * (n_closed * _GOLDEN % 1.0)) * log(max(n, 0.5) / target_count)
        else:
            x = _next(lower, upper, target_count, call)
    assert nearest is not None
    return exp(nearest[1])


def _next(lower: _Probe | None, upper: _Probe | None, target_count: int, call: int) -> float:
    """Log of the next size: outwards to bracket the target, then the secant, every third time the middle."""
    if lower and upper:
        share = log(lower[1] / target_count) / log(lower[1] / max(upper[1], 0.5))
        share = 0.5 if call % 3 == 2 else min(max(share, 0.02), 0.98)
        return lower[0] + share * (upper[0] - lower[0])
    x, n = lower or upper or (0.0, target_count)
    # on a surface the count falls with the square of the size; go a little farther, to pass the target
    step = 0.6 * log(max(n, 0.5) / target_count)
    return x + step + (0.02 if n > target_count else -0.02) * 1.5**call


def search_spacing(
    count: Callable[[float], int], points: Points, target_count: int, *, finest: float = 0.0, **limits: Any
) -> float:
    """`search_size` for a method that keeps points apart, from `surface_spacing`.

    Parameters
    ----------
    count : callable
        Points that a size gives.
    points : ndarray, shape (n, 3)
    target_count : int
    finest : float, optional
        The size below which nothing changes; by default there is none.
    **limits
        Of `search_size`.

    Raises
    ------
    NotApplicable
        Fewer points are distinct than are asked for, or are apart at the finest size.
    """
    check_distinct(points, target_count)
    if finest:
        check_resolved(points, target_count, finest)
    return search_size(count, target_count, surface_spacing(points, target_count), **limits)


def surface_spacing(points: Points, target_count: int) -> float:
    """A first guess at the size: the side of a square when half the bounding box's surface is shared out.

    A cloud without extent gives 1.
    """
    x, y, z = np.ptp(points, axis=0)
    spacing = float(np.sqrt((x * y + y * z + z * x) / target_count))
    return spacing or bounding_box_diagonal(points) / target_count or 1.0
