"""What repeated measurements allow to say: median, quartiles and a bootstrap interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

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
