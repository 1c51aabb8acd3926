"""The smallest count that keeps the plane error (eq. 27) below a bound, by bisection with the method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lpcompare.checks import check_choice, check_number
from lpcompare.errors import InputError
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Points, Simplification, Vector

_NEIGHBORS = 8
_PRECISION = 200
STATISTICS: dict[str, Callable[[Vector], float]] = {
    "mean": lambda errors: float(errors.mean()),
    "p95": lambda errors: float(np.quantile(errors, 0.95)),
    "max": lambda errors: float(errors.max()),
}


def simplify_within(
    points: Points,
    reduce: Callable[[int], Simplification],
    max_error: float | None,
    tolerance: float | None,
    statistic: str = "mean",
) -> Simplification:
    """Keep as few points as the error bound allows.

    The error falls with the count only on the whole, since every count has its own selection: the result
    keeps the bound, and a selection with half a per cent of the points less was found to break it.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    reduce : callable
        The method: from a count to a `Simplification`.
    max_error : float or None
        Largest plane error (8 neighbors), in % of the bounding-box diagonal.
    tolerance : float or None
        The same in model units; exactly one of the two.
    statistic : {"mean", "p95", "max"}
        Of the errors over the points.

    Returns
    -------
    Simplification
        ``info["error_bound"]`` and ``info["error"]`` say what was asked and what was reached, in model units.

    Raises
    ------
    InputError
        The bound is negative, or no count keeps it.
    """
    measure = STATISTICS[check_choice("statistic", statistic, STATISTICS)]
    if max_error is None:
        bound = check_number("tolerance", tolerance, 0.0)
    else:
        bound = check_number("max_error", max_error, 0.0) * bounding_box_diagonal(points) / 100

    def attempt(count: int) -> tuple[Simplification, float]:
        result = reduce(count)
        return result, measure(Comparison(points, result.points).plane_errors(_NEIGHBORS))

    whole = measure(Comparison(points, points).plane_errors(_NEIGHBORS))
    if whole > bound:
        raise InputError(
            f"The error bound is {bound:.4g} model units, but all {len(points)} points together have a "
            f"{statistic} error of {whole:.4g}: the cloud is not flatter than that. Give at least that much."
        )
    low, high = 0, len(points)
    best: tuple[Simplification, float] | None = None
    guess = max(1, high // 10)
    while high - low > max(1, high // _PRECISION):
        count = int(np.clip(guess, low + 1, high - 1))
        result, error = attempt(count)
        if error <= bound:
            high, best = count, (result, error)
        else:
            low = count
        guess = _next_guess(low, high, count, error, bound)
    result, error = best or attempt(len(points))
    if error > bound:
        raise InputError(
            f"No count of this method keeps a {statistic} error of {bound:.4g} model units; with all "
            f"{len(points)} points it reaches {error:.4g}. Give at least that much, or choose another method."
        )
    return replace(result, info={**result.info, "error_bound": bound, "error": error})


def _next_guess(low: int, high: int, count: int, error: float, bound: float) -> int:
    """Where error times count stays the same, as on a smooth surface, but well inside the bracket."""
    margin = (high - low) // 8
    expected = count * error / bound if bound > 0 else high
    return int(np.clip(expected, low + margin, high - margin)) if margin else (low + high) // 2
