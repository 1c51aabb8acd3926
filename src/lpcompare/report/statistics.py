"""What repeated measurements allow to say: spread, intervals, and when a difference is one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

LEVEL = 0.05
_RESAMPLES = 2000


@dataclass(frozen=True)
class Summary:
    """Repeated measurements of one quantity.

    Attributes
    ----------
    n : int
    median, first_quartile, third_quartile : float
    low, high : float
        Bootstrap interval of the median (percentile, 95 %); NaN below three measurements.
    """

    n: int
    median: float
    first_quartile: float
    third_quartile: float
    low: float
    high: float


def summarize(values: Sequence[float]) -> Summary:
    """Median, quartiles and the bootstrap interval of the median of at least one value.

    The resampling has a fixed seed: the same values give the same interval.
    """
    array = np.asarray(values, dtype=np.float64)
    first, middle, third = np.percentile(array, [25, 50, 75])
    low = high = np.nan
    if len(array) >= 3:
        picks = np.random.default_rng(0).integers(len(array), size=(_RESAMPLES, len(array)))
        low, high = np.percentile(np.median(array[picks], axis=1), [100 * LEVEL / 2, 100 * (1 - LEVEL / 2)])
    return Summary(len(array), float(middle), float(first), float(third), float(low), float(high))


@dataclass(frozen=True)
class Difference:
    """The mean of paired differences.

    Attributes
    ----------
    n : int
        Pairs.
    mean, low, high : float
        Mean and its 95 % interval by Student's t; NaN bounds below two pairs.
    p_value : float
        Of the hypothesis that the true mean lies within the margin; 1 below two pairs.
    """

    n: int
    mean: float
    low: float
    high: float
    p_value: float


def paired_difference(differences: Sequence[float], margin: float = 0.0) -> Difference:
    """Mean of paired differences, and whether it lies outside ``-margin .. margin``.

    Parameters
    ----------
    differences : sequence of float
        One per pair, at least one; of ratios, their logarithms.
    margin : float
        Differences up to this are of no interest.
    """
    array = np.asarray(differences, dtype=np.float64)
    n, mean = len(array), float(array.mean())
    if n < 2:
        return Difference(n, mean, np.nan, np.nan, 1.0)
    error = float(array.std(ddof=1)) / np.sqrt(n)
    beyond = abs(mean) - margin
    if error == 0.0:
        return Difference(n, mean, mean, mean, float(beyond <= 0))
    half = float(stats.t.ppf(1 - LEVEL / 2, n - 1)) * error
    p_value = min(1.0, 2 * float(stats.t.sf(beyond / error, n - 1)))
    return Difference(n, mean, mean - half, mean + half, p_value)


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values adjusted by Holm's method: of all differences called, none is false with 1 - level."""
    order = np.argsort(p_values, kind="stable")
    steps = np.asarray(p_values)[order] * np.arange(len(order), 0, -1)
    adjusted = np.empty(len(order))
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(steps))
    return [float(p) for p in adjusted]


def verdict(difference: Difference | None, p_value: float, more: str, less: str) -> str:
    """What an adjusted p-value allows to say; "n.s." is not significant."""
    if difference is None or difference.n < 2:
        return "too few pairs"
    if p_value >= LEVEL:
        return "n.s."
    return more if difference.mean > 0 else less
