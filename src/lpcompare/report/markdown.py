"""The tables of a run in Markdown."""

from __future__ import annotations

import re
from pathlib import Path

from lpcompare.benchmark.record import Run
from lpcompare.files import replace_text
from lpcompare.report.cells import gather_cells
from lpcompare.report.error_table import ErrorTable, caption, error_tables


def write_markdown(run: Run, out: Path) -> Path:
    """Write one Markdown table per model of a run to ``out``, and return its path."""
    tables = [_table(table) for table in error_tables(gather_cells(run.records))]
    replace_text(out, "\n\n".join(tables or ["The run holds no case."]) + "\n")
    return out


def _table(table: ErrorTable) -> str:
    head = ["Method", *(f"{r}: {what}" for r in table.reductions for what in ("error", "runtime"))]
    lines = [head, ["---", *["---:"] * (len(head) - 1)]]
    for method, entries in table.rows:
        cells = [escape(method)]
        for column, (error, runtime) in enumerate(entries):
            cells += [f"**{error}**" if (method, column) in table.lowest else error, runtime]
        lines.append(cells)
    body = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return f"{escape(caption(table))}\n\n{body}"


def escape(text: str) -> str:
    """Text that Markdown and the HTML within it show as it is."""
    return re.sub(r"([\\`*_{}\[\]<>#|!~&])", r"\\\1", text)
