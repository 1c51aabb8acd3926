"""Errors and runtimes of one model, methods by reductions: what the LaTeX and Markdown tables hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lpcompare.report.cells import Cell, distinct
from lpcompare.report.columns import ERROR, RUNTIME
from lpcompare.report.wording import number, percent, seconds


@dataclass(frozen=True)
class ErrorTable:
    """One model's table.

    Attributes
    ----------
    model : str
    n_points : int
    reductions : tuple of str
        "70 %", and so on.
    rows : tuple of (str, tuple of (str, str))
        Method, and for each reduction its error with the range of the repeats, and its runtime; a status
        where there is no result. Lowest error at the largest reduction first.
    lowest : frozenset of (str, int)
        Method and column of the lowest error of each reduction.
    """

    model: str
    n_points: int
    reductions: tuple[str, ...]
    rows: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    lowest: frozenset[tuple[str, int]]


CAPTION = (
    "Eq. 27 error (8 neighbours, % of the bounding-box diagonal, median{range}) and runtime (median) "
    "on {model}, {n:,} points, by the share of points removed."
)


def error_tables(cells: Sequence[Cell]) -> list[ErrorTable]:
    """One table per model."""
    return [_table([c for c in cells if c.model == model]) for model in distinct(cells, "model")]


def caption(table: ErrorTable, *, dash: str = "–") -> str:
    """What the table shows, in a sentence; the range is named where one is printed."""
    ranged = any(dash in error for _, row in table.rows for error, _ in row)
    return CAPTION.format(
        range=" and range of the repeats" if ranged else "", model=table.model, n=table.n_points
    )


def _table(cells: Sequence[Cell]) -> ErrorTable:
    reductions = sorted(distinct(cells, "reduction"))
    by_place = {(c.method, c.reduction): c for c in cells}
    methods = sorted(distinct(cells, "method"), key=lambda m: _order(by_place.get((m, reductions[-1]))))
    return ErrorTable(
        model=cells[0].model,
        n_points=cells[0].n_input,
        reductions=tuple(percent(r) for r in reductions),
        rows=tuple((m, tuple(_entry(by_place.get((m, r))) for r in reductions)) for m in methods),
        lowest=frozenset(
            (min(judged, key=lambda c: c.value(ERROR)).method, column)
            for column, r in enumerate(reductions)
            if (judged := [c for c in cells if c.reduction == r and ERROR in c.values])
        ),
    )


def _order(cell: Cell | None) -> tuple[bool, float]:
    judged = cell is not None and ERROR in cell.values
    return not judged, cell.value(ERROR) if cell and judged else 0.0


def _entry(cell: Cell | None) -> tuple[str, str]:
    if cell is None or not cell.ok:
        return cell.status if cell else "not run", ""
    if ERROR not in cell.values:
        return "no error measured", seconds(cell.value(RUNTIME))
    span = cell.values[ERROR]
    low, high = number(span.low), number(span.high)
    text = number(span.median) if low == high else f"{number(span.median)} ({low}–{high})"
    return text, seconds(cell.value(RUNTIME))
