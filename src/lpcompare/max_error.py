"""The smallest count that keeps the eq. 27 error below a bound, by bisection with the method itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lpcompare.checks import check_number
from lpcompare.errors import InputError
from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Points, Simplification

_PRECISION = 200


def simplify_within(
    points: Points, max_error: float, reduce: Callable[[int], Simplification]
) -> Simplification:
    """Keep as few points as the error bound allows.

    The error falls with the count only on the whole, since every count has its own selection: the result
    keeps the bound, and a selection with half a per cent of the points less was found to break it.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    max_error : float
        Largest eq. 27 error (8 neighbours), in % of the bounding-box diagonal.
    reduce : callable
        The method: from a count to a `Simplification`.

    Returns
    -------
    Simplification
        ``info["max_error_pct"]`` and ``info["plane_error_pct"]`` say what was asked and what was reached.

    Raises
    ------
    InputError
        ``max_error`` is negative, or smaller than the error of the whole cloud.
    """
    bound = check_number("max_error", max_error, 0.0)
    whole = Comparison(points, points).plane_error_percent()
    if whole > bound:
        raise InputError(
            f"max_error is {bound:g} % of the diagonal, but all {len(points)} points together have an error "
            f"of {whole:.4g} %: the cloud is not flatter than that. Give at least that much."
        )
    low, high = 0, len(points)
    best: tuple[Simplification, float] | None = None
    guess = max(1, high // 10)
    while high - low > max(1, high // _PRECISION):
        count = int(np.clip(guess, low + 1, high - 1))
        result = reduce(count)
        error = Comparison(points, result.points).plane_error_percent()
        if error <= bound:
            high, best = count, (result, error)
        else:
            low = count
        guess = _next_guess(low, high, count, error, bound)
    result, error = best or (reduce(len(points)), whole)
    info = dict(result.info) | {"max_error_pct": bound, "plane_error_pct": error}
    return Simplification(result.points, result.indices, result.timings, info)


def _next_guess(low: int, high: int, count: int, error: float, bound: float) -> int:
    """Where error times count stays the same, as on a smooth surface, but well inside the bracket."""
    margin = (high - low) // 8
    expected = count * error / bound if bound > 0 else high
    return int(np.clip(expected, low + margin, high - margin)) if margin else (low + high) // 2
