"""Progress of a run on stderr: the case, how many are done, the time that is left."""

from __future__ import annotations

import sys
from time import monotonic
from typing import TYPE_CHECKING

from lpcompare.benchmark.estimate import Estimate, duration

if TYPE_CHECKING:
    from lpcompare.benchmark.plan import Case
    from lpcompare.benchmark.record import Record


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
            damage = f" {case.perturbation.label}" if case.perturbation.label else ""
            words = f"{case.variant.method[:22]:22} {100 * case.reduction:g} %{damage} run {case.repeat + 1}"
            self._bar.update(self._task, description=words)
            return
        started = self._starts.pop(case)
        if not reused:
            self._estimate.learn(case, monotonic() - started)
        self._left.pop(case)
        self._bar.update(self._task, advance=1, left=self._time_left())

    def _time_left(self) -> str:
        return duration(self._estimate.remaining_s(self._left)) if self._left else "0 s"


def shows_progress(quiet: bool) -> bool:
    """Whether someone is there to see it."""
    return not quiet and sys.stderr.isatty()
