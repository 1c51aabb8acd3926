"""The data of the 3D views: clouds, errors and marks of every result, small enough to sit in the page.

Arrays become base64 text; assets/decode.js is the counterpart. Coordinates and values become 16-bit steps of
their range, which is finer than a screen shows; a mask becomes one bit per point.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.io.arrays import load_arrays
from lpcompare.report.cells import ERROR
from lpcompare.report.projections import brightness, local_normals, scale_top, up_axis
from lpcompare.types import PointCloud, Points, Vector

MOST_POINTS = 200_000
"""Points of one view; a larger cloud is thinned for display."""

MOST_VALUES = 6_000_000
"""Errors of one page, over all results; beyond it the clouds are thinned further, to keep the page small."""

_FEWEST_POINTS = 5_000
_STEPS = 65535
_LIGHT = np.array([0.35, 0.55, 0.75]) / np.linalg.norm([0.35, 0.55, 0.75])


def kept_results(run: Run, table: pd.DataFrame) -> dict[str, tuple[Path, pd.DataFrame]]:
    """Model -> the file of its clean cloud, and the cells whose results the run's folder still holds.

    Results of perturbed inputs are left out: their rows are not those of the clean cloud.
    """
    files = {
        str(entry.get("model", key)): inside(run.folder, entry.get("file", ""))
        for key, entry in run.inputs.items()
        if "~" not in str(key)
    }
    held = table.cloud.map(lambda name: inside(run.folder, name) is not None).astype(bool)
    groups = table[held & table.perturbation.eq("none")].groupby("input", sort=False)
    return {str(model): (file, group) for model, group in groups if (file := files.get(str(model)))}


def inside(folder: Path, name: object) -> Path | None:
    """A file that a run names, where it lies below the run's folder; run.json may come from anywhere."""
    path = (folder / str(name)).resolve()
    return path if path.is_file() and path.is_relative_to(folder.resolve()) else None


def percent_errors(path: Path, arrays: Mapping[str, NDArray[Any]], points: Points) -> Vector:
    """Eq. 27: distance of each original (n,) to the plane of its nearest kept points, in % of the diagonal.

    Raises
    ------
    InputError
        The file at ``path`` has no error for each of the originals.
    """
    errors = arrays.get("plane_errors")
    if errors is None or errors.shape != (len(points),):
        raise InputError(f"{path} has no error for each of the {len(points)} originals; run again.")
    return errors.astype(float) * (100 / (bounding_box_diagonal(points) or 100))


def error_scale(results: Sequence[Vector]) -> float:
    """The error at the top of a colour scale: the median of the 99th percentiles of the results.

    The largest of them would leave no colour to the others where one method is far off.
    """
    return float(np.median([scale_top(errors) for errors in results]))


def collect_views(run: Run, table: pd.DataFrame) -> list[dict[str, Any]]:
    """The views of a run: one entry per model whose clouds were kept.

    Parameters
    ----------
    run : Run
    table : DataFrame
        The run's cells.

    Returns
    -------
    list of dict
        JSON-ready; empty when the run kept no clouds.

    Raises
    ------
    InputError
        A file of the run is truncated, or does not belong to its row.
    """
    groups = kept_results(run, table)
    room = MOST_VALUES / max(1, sum(group.n_input.sum() for _, group in groups.values()))
    return [_model(run.folder, load_arrays(file)["points"], group, room) for file, group in groups.values()]


def one_cloud(cloud: PointCloud) -> dict[str, Any]:
    """The view of a single cloud, with its own colours and its scalar attributes."""
    rows = _thin(len(cloud), MOST_POINTS)
    entry = _original(_Display(cloud.points, rows), cloud.name or "cloud")
    entry["attributes"] = {
        name: pack_values(values[rows].astype(float))
        for name, values in ((k, np.asarray(v)) for k, v in cloud.attributes.items())
        if values.ndim == 1 and values.dtype.kind in "biuf" and np.isfinite(values).all()
    }
    if cloud.colors is not None:
        entry["colors"] = pack((255 * np.clip(cloud.colors[rows, :3], 0, 1)).round().astype(np.uint8))
    return entry


def pack(array: NDArray[Any]) -> str:
    """An array's bytes."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


def pack_values(values: Vector) -> dict[str, Any]:
    """Values (n,), with the smallest and the span that give them back."""
    low, span = float(values.min()), float(np.ptp(values))
    return {"low": low, "span": span, "steps": pack(_steps(values - low, np.array(span)))}


def _pack_mask(mask: NDArray[np.bool_]) -> str:
    """A mask (n,), one bit per point, least significant first."""
    return pack(np.packbits(mask, bitorder="little"))


def _steps(offsets: NDArray[np.float64], span: NDArray[np.float64]) -> NDArray[np.uint16]:
    """Shares of a span, 16 bits each; what lies outside is moved to its wall."""
    share = np.divide(offsets, span, out=np.zeros_like(offsets), where=span > 0)
    return (np.clip(share, 0, 1) * _STEPS).round().astype("<u2")


def _thin(n_points: int, most: int) -> NDArray[np.intp]:
    """Rows to show: all, or an even random choice that is the same every time."""
    if n_points <= most:
        return np.arange(n_points)
    return np.sort(np.random.default_rng(0).choice(n_points, most, replace=False))


@dataclass(frozen=True, eq=False)
class _Display:
    """A cloud (n, 3), and the rows of it that are shown."""

    points: Points
    rows: NDArray[np.intp]

    @cached_property
    def low(self) -> Vector:
        return self.points.min(axis=0)

    @cached_property
    def span(self) -> Vector:
        return np.ptp(self.points, axis=0)

    @cached_property
    def tree(self) -> Neighbors:
        return Neighbors(self.points[self.rows])


def _model(folder: Path, points: Points, group: pd.DataFrame, room: float) -> dict[str, Any]:
    """One model and its results; ``room`` is the share of the points that the page can hold."""
    most = min(MOST_POINTS, max(_FEWEST_POINTS, int(room * len(points))))
    display = _Display(points, _thin(len(points), most))
    scales: dict[str, list[Vector]] = {}
    results = []
    for cell in group.to_dict("records"):
        arrays = load_arrays(folder / cell["cloud"])
        errors = percent_errors(folder / cell["cloud"], arrays, points)[display.rows]
        scales.setdefault(f"{cell['reduction']:g}", []).append(errors)
        results.append(_result(cell, arrays, errors, display))
    tops = {reduction: error_scale(found) for reduction, found in scales.items()}
    return _original(display, group.input.iloc[0]) | {"results": results, "scales": tops}


def _original(display: _Display, name: str) -> dict[str, Any]:
    shown = display.points[display.rows]
    return {
        "name": name,
        "total": len(display.points),
        "shown": len(shown),
        "low": display.low.tolist(),
        "span": display.span.tolist(),
        "up": up_axis(display.points),
        "points": pack(_steps(shown - display.low, display.span)),
        "shade": pack((255 * brightness(local_normals(shown), _LIGHT)).round().astype(np.uint8)),
    }


def _result(
    cell: Mapping[Any, Any], arrays: Mapping[str, NDArray[Any]], errors: Vector, display: _Display
) -> dict[str, Any]:
    """One result, as the page's script reads it."""
    found: dict[str, Any] = {
        "method": cell["label"],
        "reduction": cell["reduction"],
        "count": len(arrays["points"]),
        "errors": pack_values(errors),
        "mean": cell[ERROR] if np.isfinite(cell[ERROR]) else None,
    }
    if "indices" in arrays and len(display.rows) == len(display.points):
        mask = np.zeros(len(display.points), dtype=bool)
        mask[arrays["indices"]] = True
        return found | {"kept": _pack_mask(mask)} | _marks(arrays, display)
    own = arrays["points"].astype(float)
    own = own[_thin(len(own), MOST_POINTS)]
    nearest = display.tree.query(own, 1)[1][:, 0].astype("<u4")
    places = pack(_steps(own - display.low, display.span))
    return found | {"points": places, "nearest": pack(nearest)} | _marks(arrays, display)


def _marks(arrays: Mapping[str, NDArray[Any]], display: _Display) -> dict[str, Any]:
    """Cluster, curvature and feature points, where the method said them for each original."""
    own = {k: a[display.rows] for k, a in arrays.items() if a.shape == (len(display.points),)}
    found: dict[str, Any] = {}
    if "labels" in own:
        found["labels"] = pack(own["labels"].astype("<u2"))
    if "curvature" in own:
        found["curvature"] = pack_values(np.nan_to_num(own["curvature"].astype(float)))
    if "feature_mask" in own:
        found["features"] = _pack_mask(own["feature_mask"].astype(bool))
    return found
