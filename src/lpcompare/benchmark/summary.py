"""summary.csv: the repeats and seeds of each cell put together, with quartiles and bootstrap intervals."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from lpcompare.benchmark.record import Record
from lpcompare.report.statistics import summarize

_QUANTITIES = ("runtime_s", "cpu_s", "calibration_s", "peak_memory_mib")


def summary_rows(records: Iterable[Record]) -> list[dict[str, Any]]:
    """One row per model, damage, variant, reduction and quantity, over the records that are ok."""
    cells: dict[tuple[object, ...], list[Record]] = {}
    for r in records:
        if r.status == "ok":
            key = (r.model, r.perturbation, r.perturbation_level, r.variant, r.refined, r.reduction)
            cells.setdefault(key, []).append(r)
    names = ("model", "perturbation", "perturbation_level", "variant", "refined", "reduction")
    return [
        {**dict(zip(names, key, strict=True)), "quantity": quantity, **asdict(summarize(values))}
        for key, group in cells.items()
        for quantity, values in _values(group).items()
    ]


def _values(group: list[Record]) -> dict[str, list[float]]:
    rows = [{name: getattr(r, name) for name in _QUANTITIES} | dict(r.metrics) for r in group]
    columns = {
        name: [row.get(name) for row in rows] for name in dict.fromkeys(n for row in rows for n in row)
    }
    kept = {name: [v for v in values if v is not None] for name, values in columns.items()}
    return {name: values for name, values in kept.items() if values}
