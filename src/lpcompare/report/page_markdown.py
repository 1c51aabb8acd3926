"""The page of a run in Markdown: every metric against a reference."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from lpcompare.benchmark.record import Run
from lpcompare.files import replace_text
from lpcompare.report.cells import ERROR, RUNTIME, cells, choose_reference, columns, mean_ratios, witnesses
from lpcompare.report.findings import summarize
from lpcompare.report.tables import escape_markdown as escape
from lpcompare.report.tables import listing, markdown_table, percent, plain, seconds

_PER_TABLE = 6


def write_study_page(run: Run, out: Path, reference: str = "") -> Path:
    """Write the page of a run.

    Parameters
    ----------
    run : Run
    out : Path
        A Markdown file.
    reference : str
        Method that ratios are taken to; chosen by the report where it is empty.

    Returns
    -------
    Path
        ``out``.
    """
    table = cells(run.frame)
    replace_text(out, "\n".join(_lines(run, table, reference or choose_reference(table))) + "\n")
    return out


def _lines(run: Run, table: pd.DataFrame, reference: str) -> Iterator[str]:
    facts = {name: plain(value) for name, value in run.environment.items() if not isinstance(value, dict)}
    yield f"# Methods compared: {escape(listing(list(table.input.unique())))}"
    yield f"\n    {facts.get('command', 'The run does not say with which command it was made.')}\n"
    commit = f", commit {escape(facts['commit'][:12])}" if facts.get("commit") else ""
    machine = f"{escape(facts.get('cpu', 'an unknown processor'))}, {escape(facts.get('cores', '?'))} cores"
    day, python = escape(facts.get("started", "")[:10]), escape(facts.get("python", "?"))
    yield f"{day}{commit}; {machine}, Python {python}."
    yield "Every case is in [records.csv](records.csv), the run in [run.json](run.json).\n"
    yield from (f"- {escape(sentence)}" for sentence in summarize(table))
    yield ""
    if reference:
        yield from _ratio_tables(table, reference)
        yield from _model_table(table, reference)
    bad = table[table.n_ok.eq(0)]
    if len(bad):
        yield "## Cases without a result\n"
    for cell in bad.itertuples():
        where = f"{escape(cell.input)}, {percent(cell.reduction)}"
        yield f"- {escape(cell.label)} on {where}: {escape(cell.status)}. {escape(cell.message)}"


def _ratio_tables(table: pd.DataFrame, reference: str) -> Iterator[str]:
    """Geometric mean over all cases of each metric over the reference's, methods by metrics."""
    known = columns(table)
    keys = [k for k in witnesses(known) if known[k].better == "lower"]
    means, counts = mean_ratios(table, reference, keys)
    order = means.sort_values(ERROR, kind="stable").index
    yield f"## Every metric, as a multiple of {escape(reference)}'s\n"
    yield "Geometric mean over all models and reductions; below 1 is better; in brackets the number of cases"
    yield "where it is fewer than elsewhere in the table. A metric that follows from another is left out.\n"
    for start in range(0, len(keys), _PER_TABLE):
        part = keys[start : start + _PER_TABLE]
        most = counts[part].max(axis=None)
        rows = [[escape(m), *(_mean(means.at[m, k], counts.at[m, k], most) for k in part)] for m in order]
        yield from markdown_table(["method", *(escape(known[key].title) for key in part)], rows)
        yield ""


def _model_table(table: pd.DataFrame, reference: str) -> Iterator[str]:
    models, rates = (
        list(table.input.unique()),
        listing([percent(r) for r in sorted(table.reduction.unique())]),
    )
    means = mean_ratios(table, reference, [ERROR], ["label", "input"])[0]
    wide, times = means[ERROR].unstack(), table.groupby("label")[RUNTIME].median()
    order = mean_ratios(table, reference, [ERROR])[0].sort_values(ERROR, kind="stable").index
    yield f"## Plane error by model, as a multiple of {escape(reference)}'s\n"
    yield f"Geometric mean over {rates} removed; last column: median runtime over all cases. Models differ in"
    yield "size and the machine may have been shared: runtimes are compared by repeats on one model.\n"
    rows = [
        [escape(m), *(_mean(wide.at[m, name]) for name in models), seconds(times[m]).replace("n/a", "-")]
        for m in order
    ]
    yield from markdown_table(["method", *map(escape, models), "runtime"], rows)
    yield ""


def _mean(value: float, n: int = 0, most: int = 0) -> str:
    return "-" if math.isnan(value) else f"{value:.2f}" + (f" ({n})" if n < most else "")
