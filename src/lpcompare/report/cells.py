"""The cells of a run: the repeats of one model, method and reduction put together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from lpcompare.benchmark.record import STATUSES, Record
from lpcompare.report.columns import MEASURED


@dataclass(frozen=True)
class Interval:
    """The median of the repeats, between the smallest and the largest of them."""

    median: float
    low: float
    high: float
    n: int

    @classmethod
    def of(cls, values: Sequence[float]) -> Interval:
        """The interval of one value or more."""
        return cls(median(values), min(values), max(values), len(values))


@dataclass(frozen=True)
class Cell:
    """All repeats of one model, method and reduction.

    Attributes
    ----------
    model : str
        The shape, with what was done to it where the run perturbs its inputs.
    method : str
        The method, with the settings that the run chose for it.
    reduction : float
        Share of the points removed.
    n_input, target_count : int
    statuses : mapping of str to int
        How many of the repeats ended how.
    message : str
        Why, of the first repeat that is not ok.
    subset, needs_mesh : bool or None
    values : mapping of str to Interval
        Metrics and measured columns, over the repeats that are ok.
    timings : mapping of str to float
        Median seconds per stage.
    settings : mapping
        Of the first repeat.
    cloud : str
        File of the first result that was kept, relative to the run's folder.
    perturbed : bool
        The method was given another cloud than the clean one.
    """

    model: str
    method: str
    reduction: float
    n_input: int
    target_count: int
    statuses: Mapping[str, int]
    message: str = ""
    subset: bool | None = None
    needs_mesh: bool | None = None
    values: Mapping[str, Interval] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    cloud: str = ""
    perturbed: bool = False

    @property
    def ok(self) -> bool:
        """At least one repeat has a result."""
        return bool(self.statuses.get("ok"))

    @property
    def status(self) -> str:
        """The status that all repeats share, or a count of each."""
        if len(self.statuses) == 1:
            return next(iter(self.statuses))
        return ", ".join(f"{n} {status}" for status, n in self.statuses.items())

    def value(self, key: str) -> float:
        """Median of a column; NaN where there is none."""
        return self.values[key].median if key in self.values else math.nan


def input_name(record: Record) -> str:
    """The model, with what was done to it."""
    if record.perturbation == "none":
        return record.model
    return f"{record.model} + {record.perturbation} {record.perturbation_level:g}"


def method_name(record: Record) -> str:
    """The method with the settings that were chosen, and whether its result was refined."""
    return (record.variant or record.method) + (" + exchange" if record.refined else "")


def gather_cells(records: Iterable[Record]) -> list[Cell]:
    """One cell per model, method and reduction, in the order of the records."""
    groups: dict[tuple[str, str, float], list[Record]] = {}
    for record in records:
        groups.setdefault((input_name(record), method_name(record), record.reduction), []).append(record)
    return [_cell(*key, group) for key, group in groups.items()]


def _cell(model: str, method: str, reduction: float, group: list[Record]) -> Cell:
    good = [record for record in group if record.status == "ok"]
    bad = [record for record in group if record.status != "ok"]
    first = (good or bad)[0]
    counts = {s: sum(r.status == s for r in group) for s in STATUSES}
    return Cell(
        model=model,
        method=method,
        reduction=reduction,
        n_input=first.n_input,
        target_count=first.target_count,
        statuses={status: n for status, n in counts.items() if n},
        message=bad[0].message if bad else "",
        subset=first.subset,
        needs_mesh=first.needs_mesh,
        values={key: Interval.of(values) for key, values in _columns(good).items()},
        timings={k: median([r.timings.get(k, 0.0) for r in good]) for r in good[:1] for k in r.timings},
        settings=first.settings,
        cloud=next((r.cloud for r in good if r.cloud), ""),
        perturbed=first.perturbation != "none",
    )


def _columns(good: list[Record]) -> dict[str, list[float]]:
    """Column -> the finite values of the repeats."""
    columns: dict[str, list[float]] = {}
    for record in good:
        measured = {key: getattr(record, key) for key in MEASURED}
        for key, value in {**measured, **record.metrics}.items():
            if value is not None and math.isfinite(value):
                columns.setdefault(key, []).append(float(value))
    return columns


def clean_cells(cells: Sequence[Cell]) -> Sequence[Cell]:
    """The cells of clean inputs, where there are any: a damaged input is not one more model."""
    return [cell for cell in cells if not cell.perturbed] or cells


def distinct(cells: Iterable[Cell], name: str) -> list[Any]:
    """The different values of one attribute, in the order in which they appear."""
    return list(dict.fromkeys(getattr(cell, name) for cell in cells))


def pareto_front(cells: Iterable[Cell], cost: str, error: str) -> list[Cell]:
    """The cells that no other beats in both columns (both lower is better), by ascending cost."""
    front: list[Cell] = []
    ranked = [c for c in cells if cost in c.values and error in c.values]
    for cell in sorted(ranked, key=lambda c: (c.value(cost), c.value(error))):
        if not front or cell.value(error) < front[-1].value(error):
            front.append(cell)
    return front
