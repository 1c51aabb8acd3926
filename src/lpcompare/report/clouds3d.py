"""The data of the 3D views: clouds, errors and marks of every result, small enough to sit in the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.io.arrays import load_arrays
from lpcompare.report.cells import Cell, distinct
from lpcompare.report.columns import ERROR
from lpcompare.report.packing import pack, pack_mask, pack_points, pack_values
from lpcompare.report.shading import brightness, local_normals, up_axis
from lpcompare.types import Mask, PointCloud, Points, Vector

MOST_POINTS = 200_000
"""Points of one view; a larger cloud is thinned for display."""

MOST_VALUES = 6_000_000
"""Errors of one page, over all results; beyond it the clouds are thinned further, to keep the page small."""

_FEWEST_POINTS = 5_000
_LIGHT = np.array([0.35, 0.55, 0.75]) / np.linalg.norm([0.35, 0.55, 0.75])


def collect_views(run: Run, cells: Sequence[Cell]) -> list[dict[str, Any]]:
    """The views of a run: one entry per model whose clouds were kept.

    Results of perturbed inputs have no view: their rows are not those of the clean cloud.

    Parameters
    ----------
    run : Run
    cells : sequence of Cell
        The run's.

    Returns
    -------
    list of dict
        JSON-ready; empty when the run kept no clouds.

    Raises
    ------
    InputError
        A file of the run is truncated, or does not belong to its row.
    """
    files = input_files(run)
    groups = {
        model: [c for c in cells if c.model == model and has_cloud(run, c)]
        for model in distinct(cells, "model")
        if model in files
    }
    room = MOST_VALUES / max(1, sum(group[0].n_input * len(group) for group in groups.values() if group))
    return [
        _model(run.folder, load_arrays(files[model])["points"], group, room)
        for model, group in groups.items()
        if group
    ]


def input_files(run: Run) -> dict[str, Path]:
    """Model -> the file of its clean cloud, where the run's folder still holds it."""
    files = {str(key): run.folder / str(entry.get("file", "")) for key, entry in run.inputs.items()}
    clean = {str(e.get("model", k)): files[str(k)] for k, e in run.inputs.items() if "~" not in str(k)}
    return {model: path for model, path in clean.items() if path.is_file()}


def has_cloud(run: Run, cell: Cell) -> bool:
    """The run's folder still holds a result of this cell, made from the clean cloud."""
    return bool(cell.cloud) and not cell.perturbed and (run.folder / cell.cloud).is_file()


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

    @property
    def whole(self) -> bool:
        return len(self.rows) == len(self.points)


def _model(folder: Path, points: Points, group: Sequence[Cell], room: float) -> dict[str, Any]:
    """One model and its results; ``room`` is the share of the points that the page can hold."""
    most = min(MOST_POINTS, max(_FEWEST_POINTS, int(room * len(points))))
    display = _Display(points, _thin(len(points), most))
    results = [_result(folder, cell, display) for cell in group]
    return _original(display, group[0].model) | {"results": results, "scales": _common_scales(results)}


def _original(display: _Display, name: str) -> dict[str, Any]:
    shown = display.points[display.rows]
    return {
        "name": name,
        "total": len(display.points),
        "shown": len(shown),
        "low": display.low.tolist(),
        "span": display.span.tolist(),
        "up": up_axis(display.points),
        "points": pack_points(shown, display.low, display.span),
        "shade": pack((255 * brightness(local_normals(shown), _LIGHT)).round().astype(np.uint8)),
    }


def _result(folder: Path, cell: Cell, display: _Display) -> dict[str, Any]:
    """One result, as the page's script reads it."""
    arrays = load_arrays(folder / cell.cloud)
    errors = _errors(folder / cell.cloud, arrays, display.points)[display.rows]
    found: dict[str, Any] = {
        "method": cell.method,
        "reduction": cell.reduction,
        "count": len(arrays["points"]),
        "errors": pack_values(errors),
        "high": float(np.percentile(errors, 99)),
        "mean": cell.values[ERROR].median if ERROR in cell.values else None,
    }
    if "indices" in arrays and display.whole:
        found["kept"] = pack_mask(_mask(arrays["indices"], len(display.points)))
    else:
        found |= _own_points(arrays["points"].astype(float), display)
    return found | _marks(arrays, display.rows)


def _errors(path: Path, arrays: Mapping[str, NDArray[Any]], points: Points) -> Vector:
    """Eq. 27's distance of each original, in % of the diagonal of the bounding box."""
    errors = arrays.get("plane_errors")
    if errors is None or errors.shape != (len(points),):
        raise InputError(f"{path} has no error for each of the {len(points)} originals; run again.")
    diagonal = bounding_box_diagonal(points)
    return errors.astype(float) * (100 / diagonal if diagonal > 0 else 1.0)


def _own_points(own: Points, display: _Display) -> dict[str, Any]:
    """Points that are not rows of what is shown: their places, and the shown original nearest to each."""
    own = own[_thin(len(own), MOST_POINTS)]
    nearest = display.tree.query(own, 1)[1][:, 0]
    return {"points": pack_points(own, display.low, display.span), "nearest": pack(nearest.astype("<u4"))}


def _marks(arrays: Mapping[str, NDArray[Any]], shown: NDArray[np.intp]) -> dict[str, Any]:
    """Cluster, curvature and feature points, where the method said them for each original."""
    found: dict[str, Any] = {}
    n_points = len(arrays["plane_errors"])
    arrays = {name: array for name, array in arrays.items() if array.shape == (n_points,)}
    if "labels" in arrays:
        found["labels"] = pack(arrays["labels"][shown].astype("<u2"))
    if "curvature" in arrays:
        found["curvature"] = pack_values(np.nan_to_num(arrays["curvature"][shown].astype(float)))
    if "feature_mask" in arrays:
        found["features"] = pack_mask(arrays["feature_mask"][shown].astype(bool))
    return found


def _common_scales(results: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Reduction -> the error at the top of the colour scale: the median of its results' 99th percentiles.

    The largest of them would leave no colour to the others where one method is far off.
    """
    highs: dict[str, list[float]] = {}
    for result in results:
        highs.setdefault(f"{result['reduction']:g}", []).append(result["high"])
    return {reduction: float(np.median(found)) for reduction, found in highs.items()}


def _mask(indices: NDArray[np.integer], n: int) -> Mask:
    mask = np.zeros(n, dtype=bool)
    mask[indices] = True
    return mask
