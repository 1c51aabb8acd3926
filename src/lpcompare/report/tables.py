"""The tables that a run prints: one per model and reduction, at most 100 columns wide."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from statistics import median

from lpcompare.benchmark.record import Record, Run
from lpcompare.report.alignment import WIDTH, align, cut, notes
from lpcompare.report.damage_table import format_damage
from lpcompare.report.within import BASELINE

_HEAD = ("method", "asked", "got", "points", "mesh", "eq. 27 %", "vs Poisson", "runtime", "status")


def format_run(run: Run) -> str:
    """Every table of a run, with a line on how to read them."""
    groups: dict[tuple[str, float], list[Record]] = {}
    for record in run.records:
        if record.perturbation == "none":
            groups.setdefault((record.model, record.reduction), []).append(record)
    tables = [_table(group) for group in groups.values()]
    return "\n\n".join([*tables, *format_damage(run.records), _legend(run)])


def seconds(value: float | None) -> str:
    """A duration for people: ms below one second."""
    if value is None:
        return "-"
    return f"{1000 * value:.3g} ms" if value < 0.9995 else f"{value:.2f} s"


def _table(records: list[Record]) -> str:
    variants: dict[str, list[Record]] = {}
    for record in records:
        variants.setdefault(record.variant, []).append(record)
    base = _error(variants.get(BASELINE, []))
    body = [_row(name, group, base) for name, group in variants.items()]
    lines = align([_HEAD, *sorted(body, key=lambda row: _sort_key(row[5]))], frozenset({0, 3, 4, 8}))
    return "\n".join([_title(records), lines[0], "-" * max(map(len, lines)), *lines[1:], *notes(records)])


def _title(records: list[Record]) -> str:
    first, asked = records[0], {record.target_count for record in records}
    count = f"{asked.pop():,}" if len(asked) == 1 else "as many as the paper's method kept"
    return f"{first.model}: {100 * first.reduction:g} % removed, {count} of {first.n_input:,} points asked"


def _row(name: str, group: list[Record], base: float) -> tuple[str, ...]:
    good = [record for record in group if record.status == "ok"]
    error, first = _error(group), (good or group)[0]
    counts = sorted({r.n_output for r in good if r.n_output is not None})
    kind = {True: "subset", False: "moved", None: "-"}[first.subset]
    mesh = {True: "needed", False: "no", None: "-"}[first.needs_mesh]
    times = [r.runtime_s for r in good if r.runtime_s is not None]
    return (
        cut(name + (" +refine" if first.refined else "")),
        f"{first.target_count:,}",
        "-" if not counts else f"{counts[0]:,}" if len(counts) == 1 else f"{counts[0]:,}..{counts[-1]:,}",
        kind,
        mesh,
        _number(error, ".4f"),
        _number(error / base if base else math.nan, ".2f"),
        seconds(median(times) if times else None),
        _status(group),
    )


def _error(group: Iterable[Record]) -> float:
    values = [r.metrics.get("plane_error_pct", math.nan) for r in group if r.status == "ok"]
    return median(values) if values else math.nan


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "-"


def _sort_key(cell: str) -> float:
    return math.inf if cell == "-" else float(cell)


def _status(group: list[Record]) -> str:
    statuses = [record.status for record in group]
    return " ".join(
        s if len(set(statuses)) == 1 else f"{statuses.count(s)} {s}" for s in dict.fromkeys(statuses)
    )


def _legend(run: Run) -> str:
    repeats, threads = run.plan.get("repeats", 1), run.plan.get("threads", "?")
    unreliable = (
        " Several cases ran at once: do not compare the runtimes." if run.plan.get("jobs", 1) > 1 else ""
    )
    text = (
        "eq. 27 %: mean distance of the original points to the plane of their 8 nearest kept points, in % "
        "of the bounding-box diagonal; vs Poisson: that error over MeshLab's Poisson disk at the same count; "
        f"runtime: median of {repeats} on {threads} thread{'s' * (threads != 1)}, the call alone.{unreliable}"
    )
    return "\n".join(textwrap.wrap(text, WIDTH))
