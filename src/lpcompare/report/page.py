"""One HTML file that shows a run: no network, opens from disk."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from lpcompare.benchmark.record import Run, load_run
from lpcompare.errors import UnknownName
from lpcompare.files import replace_text
from lpcompare.report.agreement import agreement_table, rank_table
from lpcompare.report.cells import Cell, clean_cells, distinct, gather_cells
from lpcompare.report.charts import choose_reference, collect_charts
from lpcompare.report.clouds3d import collect_views, one_cloud
from lpcompare.report.columns import ERROR, RUNTIME, Heading, headings
from lpcompare.report.damage import collect_damage
from lpcompare.report.findings import summarize
from lpcompare.report.wording import number, percent, quantity, tau
from lpcompare.types import PointCloud

MAIN_COLUMNS = ("n_output", ERROR, "plane_error_max_pct", "hausdorff_pct", RUNTIME, "peak_memory_mib")
"""Columns of the table that show at first; the others are one click away."""


def write_page(run_folder: str | Path, out: Path | None = None, *, reference: str = "") -> Path:
    """Write the page of a run.

    Parameters
    ----------
    run_folder : str or Path
        The run's folder, or its run.json; without its ``clouds`` the page has no 3D views and says so.
    out : Path, optional
        The file to write; ``report.html`` in the run's folder by default.
    reference : str
        The method that ratios are taken to; by default that of the printed tables.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        The run cannot be read, or the page not be written.
    UnknownName
        The reference is not a method of the run.
    """
    run = load_run(run_folder)
    out = out or run.folder / "report.html"
    remedy = f"make room, or name another file: lpcompare report {run.folder} --out FILE"
    replace_text(out, _render("page.html", page_context(run, reference)), remedy)
    return out


def write_view(cloud: PointCloud, out: Path) -> Path:
    """Write a page that shows one cloud in 3D.

    Parameters
    ----------
    cloud : PointCloud
    out : Path
        The file to write.

    Returns
    -------
    Path
        The file written.
    """
    view = one_cloud(cloud)
    title = cloud.name or "point cloud"
    replace_text(
        out,
        _render(
            "view.html", {"title": title, "views": [view], "scripts": ("theme", "decode", "views", "start")}
        ),
    )
    return out


def page_context(run: Run, reference: str = "") -> dict[str, Any]:
    """What the template shows of a run; raises `UnknownName` for a reference that is not in it."""
    cells = gather_cells(run.records)
    clean = clean_cells(cells)
    methods = distinct(cells, "method")
    if reference and reference not in methods:
        raise UnknownName("method of this run", reference, methods)
    known = headings({key for cell in cells for key in cell.values})
    return {
        "title": run.plan.get("title") or _models(clean),
        "subject": _models(clean),
        "run": run,
        "cells": sorted(cells, key=_by_error),
        "headings": known,
        "main_columns": [key for key in MAIN_COLUMNS if key in known],
        "models": distinct(cells, "model"),
        "reductions": sorted(distinct(cells, "reduction")),
        "several_repeats": any(sum(cell.statuses.values()) > 1 for cell in cells),
        "summary": summarize(cells),
        "troubles": [cell for cell in cells if cell.message],
        "settings": _settings(cells),
        "ranking": rank_table(clean, known),
        "agreement": agreement_table(clean, known),
        "charts": collect_charts(cells, known, reference or choose_reference(cells)),
        "damage": collect_damage(run.records),
        "views": collect_views(run, cells),
        "scripts": ("theme", "table", "charts", "damage", "decode", "views", "start"),
    }


def _models(cells: Sequence[Cell]) -> str:
    models = distinct(cells, "model")
    if not models:
        return "An empty run"
    return models[0] if len(models) == 1 else f"{models[0]} and {len(models) - 1} more"


def _by_error(cell: Cell) -> tuple[bool, str, float, float]:
    """Models and reductions together, lowest error first, cells without a result last."""
    return (
        not cell.ok,
        cell.model,
        cell.reduction,
        cell.values[ERROR].median if ERROR in cell.values else math.inf,
    )


def _settings(cells: Sequence[Cell]) -> dict[str, list[tuple[str, str, Mapping[str, Any]]]]:
    """Method -> its effective settings, once for every time they change from one cell to the next."""
    found: dict[str, list[tuple[str, str, Mapping[str, Any]]]] = {}
    for cell in cells:
        seen = found.setdefault(cell.method, [])
        if cell.settings and all(cell.settings != settings for _, _, settings in seen):
            seen.append((cell.model, percent(cell.reduction), cell.settings))
    return {method: seen for method, seen in found.items() if seen}


def _render(template: str, context: Mapping[str, Any]) -> str:
    environment = Environment(
        loader=PackageLoader("lpcompare.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "percent": percent, "rank": "{:.1f}".format, "tau": tau}
    environment.globals |= {"quantity": quantity, "interval": _interval, "asset": _asset, "plotly": _plotly}
    return environment.get_template(template).render(context)


def _interval(cell: Cell, key: str, heading: Heading) -> str:
    """The span of the repeats, where it is wider than what is printed."""
    span = cell.values[key]
    low, high = quantity(span.low, heading), quantity(span.high, heading)
    return f"{low} – {high}" if low != high else ""


def _asset(name: str) -> Markup:
    """One of our own scripts or style sheets, to be put into the page as it is."""
    return Markup((files("lpcompare.report") / "assets" / name).read_text(encoding="utf-8"))


def _plotly() -> Markup:
    """plotly.js, as its Python package ships it."""
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs())
