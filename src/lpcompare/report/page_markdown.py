"""A run as one Markdown page: words, every metric against a reference, every model, failures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from lpcompare.benchmark.record import Run
from lpcompare.files import replace_text
from lpcompare.report.cells import Cell, distinct, gather_cells
from lpcompare.report.charts import choose_reference
from lpcompare.report.columns import ERROR, RUNTIME, headings, metric_keys
from lpcompare.report.findings import summarize
from lpcompare.report.markdown import escape
from lpcompare.report.wording import listing, percent, seconds

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
    cells = gather_cells(run.records)
    replace_text(out, "\n".join(_lines(run, cells, reference or choose_reference(cells))) + "\n")
    return out


def _lines(run: Run, cells: Sequence[Cell], reference: str) -> Iterator[str]:
    facts = run.environment
    yield f"# Methods compared: {escape(listing(distinct(cells, 'model')))}"
    yield ""
    yield f"    {facts['command']}"
    yield ""
    commit = facts["commit"][:12] or "of a release"
    yield f"{facts['started'][:10]}, commit {commit}; {facts['cpu']}, {facts['cores']} cores, Python"
    yield f"{facts['python']}. Every row is in [records.csv](records.csv), the run in [run.json](run.json)."
    yield ""
    yield from (f"- {escape(sentence)}" for sentence in summarize(cells))
    yield ""
    if reference:
        yield from _ratio_tables(cells, reference)
        yield from _model_table(cells, reference)
    yield from _troubles(cells)


def _ratio_tables(cells: Sequence[Cell], reference: str) -> Iterator[str]:
    """Geometric mean over all cases of each metric over the reference's, methods by metrics."""
    known = headings({key for cell in cells for key in cell.values})
    keys = [k for k in metric_keys(known) if known[k].better == "lower" and known[k].unit != "model units"]
    yield f"## Every metric, as a multiple of {escape(reference)}'s"
    yield ""
    yield "Geometric mean over all models and reductions; below 1 is better; in brackets the number of cases"
    yield "where it is fewer than elsewhere in the table."
    yield ""
    for start in range(0, len(keys), _PER_TABLE):
        part = keys[start : start + _PER_TABLE]
        table = {m: [_ratios(cells, m, reference, key) for key in part] for m in _by_error(cells, reference)}
        most = max((len(r) for row in table.values() for r in row), default=0)
        yield from _table([known[key].title for key in part], table, most)


def _table(titles: Sequence[str], table: dict[str, list[list[float]]], most: int) -> Iterator[str]:
    yield f"| method | {' | '.join(escape(t) for t in titles)} |"
    yield f"|---|{'---:|' * len(titles)}"
    for method, row in table.items():
        yield f"| {escape(method)} | {' | '.join(_mean(ratios, most) for ratios in row)} |"
    yield ""


def _mean(ratios: Sequence[float], most: int) -> str:
    if not ratios:
        return "-"
    few = f" ({len(ratios)})" if len(ratios) < most else ""
    return f"{math.exp(float(np.mean(np.log(ratios)))):.2f}{few}"


def _ratios(cells: Sequence[Cell], method: str, reference: str, key: str) -> list[float]:
    """The metric over the reference's, for every model and reduction where both are positive."""
    base = {(c.model, c.reduction): c.value(key) for c in cells if c.method == reference}
    pairs = [(c.value(key), base.get((c.model, c.reduction), math.nan)) for c in cells if c.method == method]
    return [mine / theirs for mine, theirs in pairs if min(mine, theirs) > 0 and math.isfinite(mine)]


def _by_error(cells: Sequence[Cell], reference: str) -> list[str]:
    """Methods by their eq. 27 error against the reference, those without a result last."""
    means = {m: _ratios(cells, m, reference, ERROR) for m in distinct(cells, "method")}
    return sorted(means, key=lambda m: float(np.mean(np.log(means[m]))) if means[m] else math.inf)


def _model_table(cells: Sequence[Cell], reference: str) -> Iterator[str]:
    models = distinct(cells, "model")
    rates = listing([percent(r) for r in sorted(distinct(cells, "reduction"))])
    yield f"## Eq. 27 error by model, as a multiple of {escape(reference)}'s"
    yield ""
    yield f"Geometric mean over {rates} removed; last column: median runtime over all cases. Models differ in"
    yield "size and the machine may have been shared: runtimes are compared by a run of repeats on one model."
    yield ""
    yield f"| method | {' | '.join(escape(m) for m in models)} | runtime |"
    yield f"|---|{'---:|' * (len(models) + 1)}"
    for method in _by_error(cells, reference):
        mine = [c for c in cells if c.method == method]
        row = [_mean(_ratios(_of(cells, m), method, reference, ERROR), 0) for m in models]
        times = [c.value(RUNTIME) for c in mine if RUNTIME in c.values]
        row.append(seconds(float(np.median(times))) if times else "-")
        yield f"| {escape(method)} | {' | '.join(row)} |"
    yield ""


def _of(cells: Sequence[Cell], model: str) -> list[Cell]:
    return [c for c in cells if c.model == model]


def _troubles(cells: Sequence[Cell]) -> Iterator[str]:
    bad = [c for c in cells if not c.ok]
    if not bad:
        return
    yield "## Cases without a result"
    yield ""
    for cell in bad:
        where = f"{escape(cell.model)}, {percent(cell.reduction)}"
        yield f"- {escape(cell.method)} on {where}: {cell.status}. {escape(cell.message)}"
