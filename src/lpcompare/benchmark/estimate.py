"""How long the cases that are left will take."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from statistics import fmean

from lpcompare.benchmark.plan import Case

_STARTS, _STARTS_PER_POINT = 2.0, 7e-5
"""What a case takes, in starts of its process: the mean over the methods of a plain installation."""


class Estimate:
    """Seconds per case: a rough guess at first, then what was seen of the method, and of all for the others.

    Parameters
    ----------
    sizes : dict of str to int
        Points of each model, by the plan's names.
    jobs : int
        Cases at the same time.
    start_s : float
        Seconds that a case's process takes to start, as `lpcompare.benchmark.case.start_seconds` measures
        them: on a slow or busy machine the first guess is longer by as much.
    """

    def __init__(self, sizes: dict[str, int], jobs: int, start_s: float) -> None:
        self._sizes, self._jobs, self._start_s = sizes, jobs, start_s
        self._seen: dict[str, list[float]] = defaultdict(list)

    def learn(self, case: Case, seconds: float) -> None:
        """Take note of how long a case took; seconds are kept relative to the guess for its size."""
        self._seen[case.variant.label].append(seconds / self._guess(case))

    def remaining_s(self, cases: Iterable[Case]) -> float:
        """Seconds until all of ``cases`` are done."""
        every = [fmean(ratios) for ratios in self._seen.values()]
        usual = fmean(every) if every else 1.0
        total = 0.0
        for case in cases:
            ratios = self._seen.get(case.variant.label)
            total += self._guess(case) * (fmean(ratios) if ratios else usual)
        return total / self._jobs

    def _guess(self, case: Case) -> float:
        return self._start_s * (_STARTS + _STARTS_PER_POINT * self._sizes[case.model])


def duration(seconds: float) -> str:
    """A duration for people: 40 s, 3 min, 1 h 20 min."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
