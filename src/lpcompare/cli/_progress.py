"""Progress of a run on stderr: the case, how many are done, the time that is left."""

from __future__ import annotations

import subprocess
from collections import defaultdict
from collections.abc import Iterable
from statistics import fmean
from time import monotonic, perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lpcompare.benchmark.plan import Case
    from lpcompare.benchmark.record import Record

_STARTS, _STARTS_PER_POINT = 2.0, 7e-5
"""What a case takes, in starts of its process: the mean over the methods of a plain installation."""


def start_seconds() -> float:
    """Seconds on the wall clock until a process has imported what every case needs, as things are now."""
    from lpcompare.processes.children import clean_environment, python

    modules = "lpcompare.benchmark.worker, lpcompare.metrics.comparison"
    began = perf_counter()
    subprocess.run(
        python("-c", f"import {modules}"), stdin=subprocess.DEVNULL, env=clean_environment(), check=True
    )
    return perf_counter() - began


class Estimate:
    """Seconds per case: a rough guess at first, then what was seen of the method, and of all for the others.

    Parameters
    ----------
    sizes : dict of str to int
        Points of each model, by the plan's names.
    jobs : int
        Cases at the same time.
    start_s : float
        What `start_seconds` measures: on a slow or busy machine the first guess is longer by as much.
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


class RunProgress:
    """A listener of `lpcompare.benchmark.runner.run_plan`, and a context that shows a bar on a terminal.

    Parameters
    ----------
    cases : list of Case
    estimate : Estimate
    """

    def __init__(self, cases: list[Case], estimate: Estimate) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        self._left = dict.fromkeys(cases)
        self._estimate = estimate
        self._starts: dict[Case, float] = {}
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(20),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]} left"),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task("start", total=len(cases), left=self._time_left())

    def __enter__(self) -> RunProgress:
        self._bar.start()
        return self

    def __exit__(self, *reason: object) -> None:
        self._bar.stop()

    def __call__(self, case: Case, record: Record | None, *, reused: bool = False) -> None:
        """Take note of a case that starts (no record) or has ended."""
        if record is None:
            self._starts[case] = monotonic()
            done_to_it = f" {case.perturbation.label}" if case.perturbation.label else ""
            words = (
                f"{case.variant.method[:22]:22} {100 * case.reduction:g} %{done_to_it} run {case.repeat + 1}"
            )
            self._bar.update(self._task, description=words)
            return
        started = self._starts.pop(case)
        if not reused:
            self._estimate.learn(case, monotonic() - started)
        self._left.pop(case)
        self._bar.update(self._task, advance=1, left=self._time_left())

    def _time_left(self) -> str:
        return duration(self._estimate.remaining_s(self._left)) if self._left else "0 s"
