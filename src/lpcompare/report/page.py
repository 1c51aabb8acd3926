"""One HTML file that shows a run: no network, opens from disk."""

from __future__ import annotations

import gzip
import math
import os
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from lpcompare.benchmark.record import Run, load_run
from lpcompare.errors import InputError, UnknownName, printable
from lpcompare.files import replace_text
from lpcompare.report.cells import COSTS, ERROR, RUNTIME, cells, choose_reference, clean, columns
from lpcompare.report.charts import collect_charts, collect_perturbations, palettes
from lpcompare.report.clouds3d import Views, default_methods, kept_results, one_cloud, pack
from lpcompare.report.figures import cloud_still, results_still
from lpcompare.report.findings import summarize
from lpcompare.report.ranks import agreement_table, rank_over_models
from lpcompare.report.tables import number, percent, quantity
from lpcompare.types import Column, PointCloud

MAIN_COLUMNS = ("n_output", ERROR, "plane_error_max_pct", "hausdorff_pct", RUNTIME, "peak_memory_mib")
"""Columns of the table that show at first, and without scripts; the others are one click away."""


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
        The run cannot be read, the page not be written, or its name does not end in .html.
    UnknownName
        The reference is not a method of the run.
    """
    run = load_run(run_folder)
    out = _page_file(out or run.folder / "report.html")
    remedy = f"make room, or name another file: lpcompare report {run.folder} --out FILE"
    replace_text(out, run_page(run, reference)[0], remedy)
    return out


def _page_file(out: Path) -> Path:
    """The file of a page, if its name, and that of the file behind a link, is one: no scan and no run is replaced."""
    if Path(os.path.realpath(out)).suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{out} is no name of a page; name a file that ends in .html.")
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

    Raises
    ------
    InputError
        The page cannot be written, or its name does not end in .html.
    """
    out = _page_file(out)
    title = printable(cloud.name) or "point cloud"
    still = cloud_still(cloud.points)
    charts = {"cells": [], "methods": {}, "palettes": palettes(), "reference": ""}
    context = {"title": title, "kicker": "lpcompare · one cloud", "views": [one_cloud(cloud)], "page": charts}
    context |= {
        "still": still,
        "still_text": f"{title}, {len(cloud):,} points",
        "served": False,
        "alone": True,
    }
    replace_text(out, _render("view.html", context))
    return out


def run_page(run: Run, reference: str = "", *, served: bool = False) -> tuple[str, Views]:
    """The page of a run as text, and its views; raises as `write_page` does.

    Where the page is served, the arrays of a result are not in it: it asks for them.
    """
    table = cells(run.frame)
    if reference and reference not in table.label.unique():
        raise UnknownName("method of this run", reference, list(table.label.unique()))
    views = Views(run, table, reference or choose_reference(table), served=served)
    return _render("page.html", _context(run, table, views, reference) | {"served": served}), views


def _context(run: Run, table: pd.DataFrame, views: Views, reference: str) -> dict[str, Any]:
    """What the template shows of a run."""
    known, plain = columns(table), clean(table)
    perturbations = collect_perturbations(run.frame)
    viewed = {i for _, group in kept_results(run, table).values() for i in group.index}
    shown = table.assign(viewed=table.index.isin(viewed), missing=table.n_ok.eq(0))
    title = run.plan.get("title") or _models(plain)
    kicker = "lpcompare · point cloud simplification compared"
    page = collect_charts(table, known, reference or choose_reference(table))
    page |= {"palettes": palettes(), "panels": perturbations["panels"]}
    return {
        "title": title,
        "kicker": kicker if title == _models(plain) else f"{kicker} · {_models(plain)}",
        "run": run,
        "cells": shown.sort_values(["missing", "input", "reduction", ERROR], kind="stable").to_dict(
            "records"
        ),
        "headings": known,
        "measures": [key for key, column in known.items() if key not in COSTS and not column.alias],
        "main": {key: column for key, column in known.items() if key in MAIN_COLUMNS},
        "models": list(table.input.unique()),
        "reductions": sorted(table.reduction.unique()),
        "several_repeats": bool(table.n_repeats.gt(1).any()),
        "summary": summarize(table),
        "troubles": table[table.message.ne("")].to_dict("records"),
        "settings": _settings(table),
        "ranking": rank_over_models(plain) if plain.input.nunique() > 1 else None,
        "agreement": agreement_table(plain, known).to_dict("records"),
        "page": page,
        "perturbations": perturbations,
        "views": views.entries(),
        **_still(run, table, page["reference"]),
        "alone": False,
    }


def _still(run: Run, table: pd.DataFrame, reference: str) -> dict[str, str]:
    """A picture of the first model's default views, and what it shows in words."""
    for model, (_, group) in kept_results(run, table).items():
        shown = group[group.reduction.eq(group.reduction.max())]
        shown = shown[shown.label.isin(default_methods(shown, reference))]
        names = ", ".join(f"{c.label} (plane error {number(c[ERROR])} %)" for _, c in shown.iterrows())
        removed = percent(float(shown.reduction.iloc[0]))
        text = f"{model} with {removed} of its points removed, colored by the error: the original, {names}"
        return {"still": results_still(run, model, shown), "still_text": text}
    return {"still": "", "still_text": ""}


def _models(table: pd.DataFrame) -> str:
    models = table.input.unique()
    if not len(models):
        return "An empty run"
    return models[0] if len(models) == 1 else f"{models[0]} and {len(models) - 1} more"


def _settings(table: pd.DataFrame) -> dict[str, list[tuple[str, str, Mapping[str, Any]]]]:
    """Method -> its effective settings, once for every time they change from one cell to the next."""
    found: dict[str, list[tuple[str, str, Mapping[str, Any]]]] = {}
    for cell in table.to_dict("records"):
        seen = found.setdefault(cell["label"], [])
        if cell["settings"] and all(cell["settings"] != settings for _, _, settings in seen):
            seen.append((cell["input"], percent(cell["reduction"]), cell["settings"]))
    return {method: seen for method, seen in found.items() if seen}


def _render(template: str, context: Mapping[str, Any]) -> str:
    return _environment().get_template(template).render(context)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("lpcompare.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "percent": percent, "rank": "{:.1f}".format, "tau": _tau}
    environment.globals |= {"quantity": quantity, "interval": _interval, "asset": _asset, "plotly": _plotly}
    return environment


def _tau(value: float) -> str:
    """A correlation with two decimals and a true minus sign."""
    return "n/a" if math.isnan(value) else f"{value:.2f}".replace("-0.00", "0.00").replace("-", "−")


def _interval(cell: Mapping[str, Any], key: str, column: Column) -> str:
    """The span of the repeats, where it is wider than what is printed."""
    low, high = (quantity(cell[f"{key}_{end}"], column) for end in ("low", "high"))
    return f"{low} – {high}" if low != high else ""


def _asset(name: str) -> Markup:
    """One of our own scripts or style sheets, to be put into the page as it is."""
    return Markup((files("lpcompare.report") / "assets" / name).read_text(encoding="utf-8"))


@cache
def _plotly() -> Markup:
    """plotly.js, as its Python package ships it, packed; the page unpacks it when a chart comes into sight."""
    from plotly.offline import get_plotlyjs

    return Markup(pack(np.frombuffer(gzip.compress(get_plotlyjs().encode(), 6, mtime=0), np.uint8)))
