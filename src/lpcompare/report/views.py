"""The data of the 3D views: clouds, errors and marks of every result, small enough to sit in the page.

Coordinates and errors are stored as 16-bit steps of their range, which is below what a screen can show; a
subset of the input is one bit per point. The page's script turns them back into numbers.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.harness.clouds import load_arrays
from lpcompare.harness.record import Run
from lpcompare.report.cells import Cell, distinct
from lpcompare.types import PointCloud, Points, Vector

MOST_POINTS = 200_000
"""Points of one view; a larger cloud is thinned for display."""

MOST_VALUES = 6_000_000
"""Errors of one page, over all results; beyond it the clouds are thinned further, to keep the page small."""

_FEWEST_POINTS = 5_000
_STEPS = 65535
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
    shown = _thin(len(cloud), MOST_POINTS)
    entry = _original(cloud.points, cloud.name, shown)
    entry["attributes"] = {
        name: _scalar(np.asarray(values, dtype=float)[shown])
        for name, values in cloud.attributes.items()
        if np.ndim(values) == 1 and np.asarray(values).dtype.kind in "biuf" and np.isfinite(values).all()
    }
    if cloud.colors is not None:
        entry["colors"] = _text((255 * np.clip(cloud.colors[shown, :3], 0, 1)).round().astype(np.uint8))
    return entry


def _thin(n_points: int, most: int) -> NDArray[np.intp]:
    """Rows to show: all, or an even random choice that is the same every time."""
    if n_points <= most:
        return np.arange(n_points)
    return np.sort(np.random.default_rng(0).choice(n_points, most, replace=False))


def _model(folder: Path, points: Points, group: Sequence[Cell], room: float) -> dict[str, Any]:
    """One model and its results; ``room`` is the share of the points that the page can hold."""
    most = min(MOST_POINTS, max(_FEWEST_POINTS, int(room * len(points))))
    shown = _thin(len(points), most)
    entry = _original(points, group[0].model, shown)
    tree = Neighbors(points[shown])
    results = [_result(folder, cell, points, shown, tree, entry) for cell in group]
    return entry | {"results": results, "scales": _common_scales(results)}


def _original(points: Points, name: str, shown: NDArray[np.intp]) -> dict[str, Any]:
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    return {
        "name": name,
        "total": len(points),
        "shown": len(shown),
        "low": low.tolist(),
        "span": span.tolist(),
        "up": up_axis(points),
        "points": _text(_steps(points[shown] - low, span)),
        "shade": _text((255 * shade(points[shown])).round().astype(np.uint8)),
    }


def _result(
    folder: Path, cell: Cell, points: Points, shown: NDArray[np.intp], tree: Neighbors, entry: Mapping[str, Any]
) -> dict[str, Any]:
    """One result, as the page's script reads it."""
    arrays = load_arrays(folder / cell.cloud)
    errors = _errors(folder, cell, arrays, points)[shown]
    found: dict[str, Any] = {
        "method": cell.method,
        "reduction": cell.reduction,
        "count": len(arrays["points"]),
        "errors": _scalar(errors),
        "high": float(np.percentile(errors, 99)),
        "mean": cell.value("plane_error_pct"),
    }
    if "indices" in arrays and arrays["indices"].size and len(shown) == len(points):
        found["kept"] = _bits(_mask(arrays["indices"], len(points)))
    else:
        found |= _own_points(arrays, tree, entry)
    return found | _marks(arrays, shown)


def _errors(folder: Path, cell: Cell, arrays: Mapping[str, NDArray[Any]], points: Points) -> Vector:
    """Eq. 27's distance of each original, in % of the diagonal of the bounding box."""
    errors = arrays.get("plane_errors")
    if errors is None or errors.shape != (len(points),):
        raise InputError(f"{folder / cell.cloud} has no error for each of the {len(points)} originals; run again.")
    diagonal = bounding_box_diagonal(points)
    return errors.astype(float) * (100 / diagonal if diagonal > 0 else 1.0)


def _own_points(arrays: Mapping[str, NDArray[Any]], tree: Neighbors, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Points that are not rows of what is shown: their places, and the shown original nearest to each."""
    own = arrays["points"].astype(float)
    own = own[_thin(len(own), MOST_POINTS)]
    return {
        "points": _text(_steps(own - entry["low"], np.array(entry["span"]))),
        "nearest": _text(tree.query(own, 1)[1][:, 0].astype("<u4")),
        "moved": not arrays.get("indices", np.empty(0)).size,
    }


def _marks(arrays: Mapping[str, NDArray[Any]], shown: NDArray[np.intp]) -> dict[str, Any]:
    """Cluster, curvature and feature points, where the method said them for each original."""
    found: dict[str, Any] = {}
    if "labels" in arrays:
        found["labels"] = _text(arrays["labels"][shown].astype("<u2"))
    if "curvature" in arrays:
        found["curvature"] = _scalar(np.nan_to_num(arrays["curvature"][shown].astype(float)))
    if "feature_mask" in arrays:
        found["features"] = _bits(arrays["feature_mask"][shown].astype(bool))
    return found


def _common_scales(results: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Reduction -> the error at the top of the colour scale: the median of its results' 99th percentiles.

    The largest of them would leave no colour to the others where one method is far off.
    """
    highs: dict[str, list[float]] = {}
    for result in results:
        highs.setdefault(f"{result['reduction']:g}", []).append(result["high"])
    return {reduction: float(np.median(found)) for reduction, found in highs.items()}


def up_axis(points: Points) -> str:
    """"z" for a cloud that lies flat in x and y, as scanned ground does; "y", as scanned objects do, else."""
    x, y, z = np.ptp(points, axis=0)
    return "z" if z < 0.5 * min(x, y) else "y"


def shade(points: Points) -> Vector:
    """Brightness (n,) from 0 to 1 of each point under a light from the front, by its local plane (n, 3)."""
    if len(points) < 3:
        return np.ones(len(points))
    centred = points - bounding_box_center(points)
    brightness = np.empty(len(points))
    tree = Neighbors(centred)
    for rows in np.array_split(np.arange(len(points)), len(points) // 65536 + 1):
        indices = tree.query(centred[rows], 12)[1]
        brightness[rows] = np.abs(fit_planes(centred[indices])[1] @ _LIGHT)
    return brightness


def _scalar(values: Vector) -> dict[str, Any]:
    """Values as 16-bit steps between their smallest and largest."""
    low = float(values.min())
    span = float(np.ptp(values))
    return {"low": low, "span": span, "steps": _text(_steps(values - low, np.array(span)))}


def _steps(offsets: NDArray[np.float64], span: NDArray[np.float64]) -> NDArray[np.uint16]:
    """Offsets from the low end, as steps of the span; what lies outside it is moved to its end."""
    share = np.divide(offsets, span, out=np.zeros_like(offsets), where=span > 0)
    return (np.clip(share, 0, 1) * _STEPS).round().astype("<u2")


def _mask(indices: NDArray[np.integer], n: int) -> NDArray[np.bool_]:
    mask = np.zeros(n, dtype=bool)
    mask[indices] = True
    return mask


def _bits(mask: NDArray[np.bool_]) -> str:
    return _text(np.packbits(mask, bitorder="little"))


def _text(array: NDArray[Any]) -> str:
    """An array's bytes in base64."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
