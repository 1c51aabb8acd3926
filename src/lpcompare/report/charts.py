"""The numbers behind the page's charts; assets/charts.js draws with plotly.js what is chosen there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from lpcompare.report.cells import Cell, distinct, pareto_front
from lpcompare.report.columns import ERROR, RUNTIME, Heading, metric_keys
from lpcompare.report.styles import method_styles, stage_styles
from lpcompare.report.tables import BASELINE


def collect_charts(cells: Sequence[Cell], known: Mapping[str, Heading], reference: str) -> dict[str, Any]:
    """Everything that the charts can show.

    Parameters
    ----------
    cells : sequence of Cell
    known : mapping of str to Heading
        The columns of the run.
    reference : str
        The method that ratios are taken to at first.

    Returns
    -------
    dict
        JSON-ready: ``cells`` with median, low and high of each column, ``fronts`` by model, column and
        reduction, ``methods`` and, in the order of the work, ``stages`` with their colours, ``headings``,
        ``measures`` to choose from.
    """
    good = [cell for cell in cells if cell.ok]
    styles = method_styles(distinct(cells, "method"))
    measures = metric_keys(known)
    return {
        "reference": reference,
        "headings": {key: asdict(h) | {"label": h.label} for key, h in known.items()},
        "measures": measures,
        "methods": {method: asdict(style) for method, style in styles.items()},
        "stages": [[stage, asdict(style)] for stage, style in stage_styles(stage_names(good)).items()],
        "models": distinct(good, "model"),
        "reductions": sorted(distinct(good, "reduction")),
        "cells": [_entry(cell) for cell in good],
        "fronts": {
            m: _fronts([c for c in good if c.model == m], known, measures) for m in distinct(good, "model")
        },
    }


def choose_reference(cells: Sequence[Cell]) -> str:
    """The baseline of the printed tables where the run holds it, else the fastest that ended most often."""
    if any(cell.ok and cell.method == BASELINE for cell in cells):
        return BASELINE
    good = [cell for cell in cells if cell.ok and RUNTIME in cell.values]
    if not good:
        return ""
    spans = {m: [c.value(RUNTIME) for c in good if c.method == m] for m in distinct(good, "method")}
    return min(spans, key=lambda method: (-len(spans[method]), max(spans[method]), method))


def stage_names(cells: Iterable[Cell]) -> list[str]:
    """The stages that the methods tell apart, in the order in which they appear."""
    return list(dict.fromkeys(stage for cell in cells for stage in cell.timings))


def _entry(cell: Cell) -> dict[str, Any]:
    return {
        "model": cell.model,
        "method": cell.method,
        "reduction": cell.reduction,
        "values": {k: [_short(v) for v in (i.median, i.low, i.high)] for k, i in cell.values.items()},
        "timings": {stage: _short(value) for stage, value in cell.timings.items()},
    }


def _fronts(
    cells: Sequence[Cell], known: Mapping[str, Heading], measures: Iterable[str]
) -> dict[str, dict[str, list[str]]]:
    """Column -> reduction -> the methods on the front of runtime against that column."""
    return {
        key: {
            f"{r:g}": [c.method for c in pareto_front([c for c in cells if c.reduction == r], RUNTIME, key)]
            for r in distinct(cells, "reduction")
        }
        for key in measures
        if key == ERROR or known[key].better == "lower"
    }


def _short(value: float) -> float:
    """Six digits: more than the repeats can tell apart, and a small page."""
    return float(f"{value:.6g}")
