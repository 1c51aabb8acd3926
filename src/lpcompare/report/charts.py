"""The numbers behind the page's charts; assets/charts.js draws with plotly.js what is chosen there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from lpcompare.registry import METHODS
from lpcompare.report.cells import LEVELS, axis_title, perturbation_curves, stage_name
from lpcompare.report.styles import CLUSTER_COLORS, method_styles, stage_styles
from lpcompare.types import Column


def collect_charts(table: pd.DataFrame, known: Mapping[str, Column], reference: str) -> dict[str, Any]:
    """Everything that the charts can show.

    Parameters
    ----------
    table : DataFrame
        The run's cells.
    known : mapping of str to Column
        Its numbers.
    reference : str
        The method that ratios are taken to at first.

    Returns
    -------
    dict
        JSON-ready: ``cells`` with median, low and high of each column, ``methods`` with their looks, family and
        source, ``stages`` in the order of the work with their colours, ``headings``, ``models``, and the
        ``reference``.
    """
    good = table[table.n_ok > 0]
    stages = [key for key in good if stage_name(key) and good[key].notna().any()]
    names = table.drop_duplicates("label").set_index("label").method
    return {
        "reference": reference,
        "headings": {key: {**asdict(c), "label": axis_title(c)} for key, c in known.items()},
        "methods": {m: asdict(look) | _facts(names[m]) for m, look in method_styles(names.index).items()},
        "stages": [[name, asdict(s)] for name, s in stage_styles(map(stage_name, stages)).items()],
        "models": list(good.input.unique()),
        "cells": [_entry(cell, known, stages) for cell in good.to_dict("records")],
    }


def palettes() -> dict[str, list[list[int]]]:
    """The colour maps of the 3D views, red, green and blue from 0 to 255."""
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb

    maps = {name: colormaps[name](np.arange(256))[:, :3] for name in ("viridis", "cividis")}
    maps["clusters"] = np.array([to_rgb(color) for color in CLUSTER_COLORS])
    return {name: (255 * colors).round().astype(int).tolist() for name, colors in maps.items()}


def _facts(method: str) -> dict[str, str]:
    """Family and BibTeX entry of a method; empty for one that is not installed any more."""
    if method not in METHODS:
        return {"family": "", "bibtex": ""}
    traits = METHODS.traits(method)
    note = traits.source.replace("{", "(").replace("}", ")")
    bibtex = f"@misc{{{method},\n  title = {{{METHODS.summary(method)}}},\n  note = {{{note}}},\n"
    return {
        "family": traits.family,
        "bibtex": f"{bibtex}  howpublished = {{{traits.wraps}}}\n}}\n" if note else "",
    }


def collect_perturbations(frame: pd.DataFrame) -> dict[str, Any]:
    """What the page shows of the perturbed inputs.

    Returns
    -------
    dict
        JSON-ready: ``panels``, whose curves are lists of [level, error] where there is a result, and the
        ``models``, ``reductions`` and ``kinds`` with their captions to choose from, none where nothing was
        perturbed; ``blind``, the methods that saw no outlier: added points belong to no face of the mesh that
        they work on.
    """
    curves = perturbation_curves(frame)
    panels = []
    for (model, reduction, kind), group in curves.groupby(level=[0, 1, 2], sort=False) if len(curves) else ():
        points = {m: list(curve.dropna().items()) for m, curve in group.droplevel([0, 1, 2]).iterrows()}
        panels.append({"model": model, "reduction": reduction, "kind": kind, "curves": points})
    blind = frame.label[frame.needs_mesh.eq(True).fillna(False) & frame.perturbation.eq("outliers")]
    return {
        "panels": panels,
        "models": list(dict.fromkeys(panel["model"] for panel in panels)),
        "reductions": sorted({panel["reduction"] for panel in panels}),
        "kinds": {panel["kind"]: LEVELS.get(panel["kind"], panel["kind"]) for panel in panels},
        "blind": list(blind.unique()),
    }


def _entry(cell: Mapping[str, Any], known: Iterable[str], stages: Iterable[str]) -> dict[str, Any]:
    spans = {key: [_short(cell[f"{key}{end}"]) for end in ("", "_low", "_high")] for key in known}
    return {
        "model": cell["input"],
        "method": cell["label"],
        "reduction": cell["reduction"],
        "values": {key: span for key, span in spans.items() if span[0] == span[0]},
        "timings": {stage_name(key): _short(cell[key]) for key in stages if cell[key] == cell[key]},
    }


def _short(value: float) -> float:
    """Six digits: more than the repeats can tell apart, and a small page."""
    return float(f"{value:.6g}")
