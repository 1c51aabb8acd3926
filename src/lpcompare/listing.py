"""Tables of what there is: methods, metrics and models, importing no rival."""

from __future__ import annotations

import pandas as pd

from lpcompare.registry import METHODS, METRICS


def methods() -> pd.DataFrame:
    """Every registered method with its traits.

    Returns
    -------
    DataFrame
        Indexed by name. Columns: family, summary, result ("subset" or "new points"), count ("exact" or
        "near"), needs ("points" or "mesh"), progressive, reading, installed, install (the line that installs
        what is missing), wraps, source, licence, origin (the package it comes from).

    Examples
    --------
    >>> import lpcompare
    >>> lpcompare.methods().loc["farthest_point", "result"]
    'subset'
    """
    return pd.DataFrame({name: _traits(name) for name in METHODS}).T.rename_axis("method")


def _traits(name: str) -> dict[str, object]:
    traits, missing = METHODS.traits(name), METHODS.missing(name)
    return {
        "family": traits.family,
        "summary": METHODS.summary(name),
        "result": "new points" if traits.moves_points else "subset",
        "count": "exact" if traits.exact_count else "near",
        "needs": "mesh" if traits.needs_mesh else "points",
        "progressive": traits.progressive,
        "reading": traits.reading,
        "installed": not missing,
        "install": missing,
        "wraps": traits.wraps,
        "source": traits.source,
        "licence": traits.licence,
        "origin": METHODS.origin(name),
    }


def metrics() -> pd.DataFrame:
    """Every column that a metric reports.

    Returns
    -------
    DataFrame
        Indexed by column. Columns: metric, title, unit, better ("lower" or "higher"), alias (the column
        that this one follows from; ranks do not count it), summary.

    Examples
    --------
    >>> import lpcompare
    >>> lpcompare.metrics().loc["plane_error_pct", "metric"]
    'plane_error'
    """
    rows = {
        key: {
            "metric": name,
            "title": column.title,
            "unit": column.unit,
            "better": column.better,
            "alias": column.alias,
            "summary": METRICS.summary(name),
        }
        for name in METRICS
        for key, column in METRICS.columns(name).items()
    }
    return pd.DataFrame(rows).T.rename_axis("column")


def models() -> pd.DataFrame:
    """Every model of the catalogue.

    Returns
    -------
    DataFrame
        Indexed by name, with the column summary.

    Examples
    --------
    >>> import lpcompare
    >>> "bunny" in lpcompare.models().index
    True
    """
    from lpcompare.models import model_names, model_summary

    rows = {name: {"summary": model_summary(name)} for name in model_names()}
    return pd.DataFrame(rows).T.rename_axis("model")
