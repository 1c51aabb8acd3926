"""A run's table put together: what its numbers are called, its cells, ratios, fronts and curves.

`lpcompare.benchmark.record.Run.frame` holds one row per case and repeat. A *cell* is all repeats of one
input, method (with its settings) and reduction; whatever a report shows is a view of the table of cells.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache

import numpy as np
import pandas as pd

from lpcompare.errors import Unavailable
from lpcompare.registry import METRICS
from lpcompare.types import Column

ERROR = "plane_error_pct"
"""The column of eq. 27, by which a report speaks of "the error"."""

RUNTIME = "runtime_s"
REFERENCE = "poisson_disk"
"""The method that ratios are taken to, where the run holds it."""

CELL = ["input", "label", "reduction"]
"""What the rows of one cell share."""

COSTS = {
    "n_output": Column("points", "Points kept", better=""),
    RUNTIME: Column("s", "Runtime"),
    "calibration_s": Column("s", "Search for the setting that gives the count, not timed"),
    "peak_memory_mib": Column("MiB", "Peak memory"),
}
"""What is measured of every method beside the metrics."""

LEVELS = {
    "noise": "Noise: standard deviation, in mean spacings",
    "outliers": "Outliers: points added, as a share of the cloud",
    "uneven": "Uneven: share of points gone at the thin end",
    "missing": "Missing: share of points cut out as one ball",
}
"""What the level of each kind of perturbation says."""

_FIELDS = {
    *CELL, "model", "method", "variant", "refined", "perturbation", "perturbation_level", "n_input",
    "target_count", "seed", "repeat", "status", "message", "cpu_s", "reference_s", "reference_cpu_s",
    "foreign_load", "subset", "needs_mesh", "settings", "info", "points_sha256", "key", "cloud", "n_repeats",
    "n_ok",
}  # fmt: skip
"""What a frame or a table of cells holds beside the numbers that a report shows."""

_FIRST = ["model", "method", "perturbation", "n_input", "target_count", "subset", "needs_mesh", "settings"]


def columns(table: pd.DataFrame) -> dict[str, Column]:
    """The numbers that a frame or a table of cells has a value of: eq. 27, the costs, the metrics by name."""
    spans = {f"{key}{end}" for key in table for end in ("_low", "_high")}
    held = [k for k in table if k not in spans | _FIELDS and not stage_name(k) and _is_number(table[k])]
    ordered = [ERROR, *COSTS, *sorted(set(held) - {ERROR, *COSTS})]
    known = COSTS | _declared()
    return {
        k: known.get(k, Column("", k, better="")) for k in ordered if k in held and table[k].notna().any()
    }


def witnesses(known: Mapping[str, Column]) -> list[str]:
    """The metrics with a direction that say something of their own: no costs, no aliases."""
    return [k for k, c in known.items() if k not in COSTS and c.better and not c.alias]


def axis_title(column: Column) -> str:
    """Title and unit, as on an axis; a title that counts points has said so."""
    return f"{column.title} [{column.unit}]" if column.unit not in ("", "points") else column.title


def stage_name(key: str) -> str:
    """The stage whose seconds a column holds; empty for another column."""
    found = re.fullmatch(r"time_(.+)_s", str(key))
    return found[1] if found else ""


def cells(frame: pd.DataFrame) -> pd.DataFrame:
    """One row per input, method and reduction, in the order of the frame.

    Parameters
    ----------
    frame : DataFrame
        `lpcompare.benchmark.record.Run.frame`.

    Returns
    -------
    DataFrame
        ``input``, ``label``, ``reduction``; ``n_repeats``, ``n_ok``; ``status`` that all repeats share, or a
        count of each; ``message`` of the first repeat that is not ok; the median of every number over the
        repeats that are ok, with the smallest and the largest as ``<key>_low`` and ``<key>_high``; seconds
        per stage; what the first repeat says of the rest; ``cloud``, the first that was kept. `ERROR` is
        there even where no case has one.
    """
    if ERROR not in frame:
        frame = frame.assign(**{ERROR: np.nan})
    ok = frame.status.eq("ok")
    first = frame.loc[ok.sort_values(ascending=False, kind="stable").index].drop_duplicates(CELL)
    groups = frame.groupby(CELL, sort=False)
    table = groups.agg(n_repeats=("status", "size"), status=("status", _statuses))
    table = table.assign(n_ok=ok.groupby([frame[k] for k in CELL], sort=False).sum())
    table = table.join(first.set_index(CELL)[_FIRST])
    for key, rows in (("message", ~ok), ("cloud", ok & frame.cloud.ne(""))):
        table = table.join(frame[rows].drop_duplicates(CELL).set_index(CELL)[key])
    truths = {
        name: table[name].astype(object).where(table[name].notna(), None) for name in ("subset", "needs_mesh")
    }
    table = table.fillna({"message": "", "cloud": ""}).assign(**truths)
    return table.join(_spans(frame[ok])).reset_index()


def clean(table: pd.DataFrame) -> pd.DataFrame:
    """The cells of clean inputs, where there are any: a perturbed input is not one more model."""
    rows = table.perturbation.eq("none")
    return table[rows] if rows.any() else table


def choose_reference(table: pd.DataFrame) -> str:
    """Poisson disk where the run holds it, else the fastest that ended most often; empty without a result."""
    good = table.dropna(subset=[RUNTIME])
    if good.label.eq(REFERENCE).any() or good.empty:
        return REFERENCE if len(good) else ""
    spans = good.groupby("label")[RUNTIME].agg(["size", "max"]).reset_index()
    return str(spans.sort_values(["size", "max", "label"], ascending=[False, True, True]).label.iloc[0])


def ratios(table: pd.DataFrame, reference: str, keys: Sequence[str]) -> pd.DataFrame:
    """Columns of every cell over the reference's on the same input and reduction, with the cell's own index.

    NaN where one of both is not positive.
    """
    place, keys = ["input", "reduction"], list(keys)
    positive = table[keys].where(table[keys] > 0)
    base = positive.set_axis(pd.MultiIndex.from_frame(table[place]))[table.label.eq(reference).to_numpy()]
    return positive / base.reindex(pd.MultiIndex.from_frame(table[place])).to_numpy()


def mean_ratios(
    table: pd.DataFrame, reference: str, keys: Sequence[str], by: Sequence[str] = ("label",)
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Geometric mean of the ratios to the reference, and the number of cells behind it, by group."""
    groups = np.log(ratios(table, reference, keys)).groupby([table[key] for key in by], sort=False)
    return groups.mean().map(np.exp), groups.count()


def pareto_front(table: pd.DataFrame, cost: str, error: str) -> pd.DataFrame:
    """The cells that no other beats in both columns (both lower is better), by ascending cost."""
    ranked = table.dropna(subset=[cost, error]).sort_values([cost, error], kind="stable")
    return ranked[ranked[error] < ranked[error].astype(float).cummin().shift(fill_value=np.inf)]


def perturbation_curves(frame: pd.DataFrame) -> pd.DataFrame:
    """Mean eq. 27 error over seeds and repeats, against the clean cloud.

    Returns
    -------
    DataFrame
        Index: ``model``, ``reduction``, ``kind``, ``label``; one column per level, 0 is the clean input. NaN
        where a case has no result; empty where nothing was perturbed.
    """
    frame = frame.assign(error=frame[ERROR].where(frame.status.eq("ok")) if ERROR in frame else np.nan)
    kinds = [kind for kind in frame.perturbation.unique() if kind != "none"]
    parts = [frame[frame.perturbation.isin(["none", kind])].assign(kind=kind) for kind in kinds]
    if not parts:
        return pd.DataFrame()
    by = ["model", "reduction", "kind", "label", "perturbation_level"]
    means = pd.concat(parts).groupby(by, sort=False).error.agg(lambda errors: errors.mean(skipna=False))
    return means.unstack().sort_index(axis=1).reindex(means.index.droplevel(-1).unique()).dropna(how="all")


def _spans(ok: pd.DataFrame) -> pd.DataFrame:
    """Median, smallest and largest of every number, and the median seconds of every stage."""
    numbers, stages = (
        list(dict.fromkeys((ERROR, *COSTS, *columns(ok)))),
        [key for key in ok if stage_name(key)],
    )
    values = ok[[*numbers, *stages]].astype(float).replace([np.inf, -np.inf], np.nan)
    groups = values.groupby([ok[k] for k in CELL], sort=False)
    middle, low, high = groups.median(), groups.min(), groups.max()
    low, high = low[numbers].add_suffix("_low"), high[numbers].add_suffix("_high")
    spans = middle.join(low).join(high)
    return spans[[*(f"{key}{end}" for key in numbers for end in ("", "_low", "_high")), *stages]]


def _statuses(statuses: pd.Series) -> str:
    counts = statuses.value_counts(sort=False)
    return statuses.iloc[0] if len(counts) == 1 else ", ".join(f"{n} {name}" for name, n in counts.items())


def _is_number(values: pd.Series) -> bool:
    return pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)


@cache
def _declared() -> dict[str, Column]:
    """The columns of every metric; a broken one of another package has none."""
    return {key: column for name in METRICS for key, column in _columns_of(name)}


def _columns_of(name: str) -> Iterable[tuple[str, Column]]:
    try:
        return METRICS.columns(name).items()
    except Unavailable:
        return ()
