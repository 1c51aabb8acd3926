"""The cells of a run as a flat table: one row per model, method and reduction.

Columns, in this order; names and types do not change between versions, new ones are added at the end of their
group. Each column holds one type, so the file reads into Parquet as it is.

========================================  ======  =====================================================
column                                    type    meaning
========================================  ======  =====================================================
model, method                             text    the shape; the method with the settings that were chosen
reduction                                 real    share of the points removed
n_input, target_count                     int     points of the input, points asked for
n_repeats, n_ok                           int     repeats run, repeats with a result
status, message                           text    how the repeats ended, and why not ok
subset, needs_mesh                        bool    ``true``, ``false``, or empty where unknown
``<column>``                              real    median of the repeats, for every metric and measured column
``<column>_low``, ``<column>_high``       real    smallest and largest of the repeats
``time_<stage>_s``                        real    median seconds of a stage
========================================  ======  =====================================================

An empty field is a missing value. `records.csv` of a run holds the single repeats.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lpcompare.benchmark.record import Run
from lpcompare.files import replace_text
from lpcompare.report.cells import Cell, gather_cells
from lpcompare.report.columns import headings

_FIXED = ("model", "method", "reduction", "n_input", "target_count", "n_repeats", "n_ok", "status", "message",
          "subset", "needs_mesh")  # fmt: skip


def write_csv(run: Run, out: Path) -> Path:
    """Write the cells of a run to ``out``, and return its path."""
    cells = gather_cells(run.records)
    text = io.StringIO()
    writer = csv.DictWriter(text, _columns(cells), lineterminator="\n")
    writer.writeheader()
    writer.writerows(_row(cell) for cell in cells)
    replace_text(out, text.getvalue())
    return out


def _columns(cells: Sequence[Cell]) -> list[str]:
    values = headings({key for cell in cells for key in cell.values})
    stages = dict.fromkeys(stage for cell in cells for stage in cell.timings)
    spans = (f"{key}{end}" for key in values for end in ("", "_low", "_high"))
    return [*_FIXED, *spans, *(f"time_{stage}_s" for stage in stages)]


def _row(cell: Cell) -> dict[str, Any]:
    row: dict[str, Any] = {name: getattr(cell, name) for name in _FIXED if hasattr(cell, name)}
    row |= {"n_repeats": sum(cell.statuses.values()), "n_ok": cell.statuses.get("ok", 0)}
    row |= {name: _truth(row[name]) for name in ("subset", "needs_mesh")}
    for key, span in cell.values.items():
        row |= {key: span.median, f"{key}_low": span.low, f"{key}_high": span.high}
    return row | {f"time_{stage}_s": value for stage, value in cell.timings.items()}


def _truth(value: bool | None) -> str:
    return "" if value is None else str(value).lower()
