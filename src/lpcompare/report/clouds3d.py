"""The data of the 3D views: clouds, errors and marks of every result, small enough to sit in the page.

Arrays become base64 text; assets/data.js is the counterpart. Coordinates and values become 16-bit steps of
their range, which is finer than a screen shows; a mask becomes one bit per point.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.io.arrays import load_arrays
from lpcompare.report.cells import ERROR
from lpcompare.report.projections import scale_top, up_axis
from lpcompare.types import PointCloud, Points, Vector

if TYPE_CHECKING:
    from scipy.spatial import KDTree

MOST_POINTS = 200_000
"""Points of one view of a run; a larger cloud is thinned for display."""

MOST_OF_ONE = 2_000_000
"""Points of the view of a single cloud."""

MOST_VALUES = 6_000_000
"""Errors of one page, over all results; beyond it the clouds are thinned further, to keep the page small."""

_FEWEST_POINTS = 5_000
_STEPS = 65535
_PAPER = ("lp_printed", "lp_density")


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


class Views:
    """The 3D views of a run: one entry per model whose clouds were kept.

    Parameters
    ----------
    run : Run
    table : DataFrame
        The run's cells.
    reference : str
        The method that is shown first.
    served : bool
        Each result is left out and asked for by its address, as a server answers it with `result`.

    Raises
    ------
    InputError
        A file of the run is truncated, or does not belong to its row.
    """

    def __init__(self, run: Run, table: pd.DataFrame, reference: str, *, served: bool = False) -> None:
        self._folder, self._served = run.folder, served
        self._groups = list(kept_results(run, table).values())
        asked = 1 if served else max(1, sum(int(group.n_input.sum()) for _, group in self._groups))
        self._room = 1.0 if served else MOST_VALUES / asked
        self._displays = [self._display(load_arrays(file)["points"]) for file, _ in self._groups]
        self._reference = reference

    def entries(self) -> list[dict[str, Any]]:
        """What the page shows, JSON-ready; empty when the run kept no clouds."""
        return [self._model(i) for i in range(len(self._groups))]

    def result(self, model: int, number: int) -> dict[str, Any]:
        """One result with its arrays."""
        cell, display = self._groups[model][1].iloc[number], self._displays[model]
        arrays, errors = self._errors(model, cell)
        return _heads(cell, arrays, errors) | _result(arrays, errors[display.rows], display)

    def _display(self, points: Points) -> _Display:
        most = MOST_POINTS if self._served else max(_FEWEST_POINTS, int(self._room * len(points)))
        return _Display(points, _thin(len(points), min(MOST_POINTS, most)))

    def _errors(self, model: int, cell: pd.Series) -> tuple[dict[str, NDArray[Any]], Vector]:
        path = self._folder / cell.cloud
        arrays = load_arrays(path)
        return arrays, percent_errors(path, arrays, self._displays[model].points)

    def _model(self, model: int) -> dict[str, Any]:
        group, display = self._groups[model][1], self._displays[model]
        scales: dict[str, list[Vector]] = {}
        results = []
        for number, (_, cell) in enumerate(group.iterrows()):
            arrays, errors = self._errors(model, cell)
            scales.setdefault(f"{cell.reduction:g}", []).append(errors)
            found = _heads(cell, arrays, errors)
            body = _result(arrays, errors[display.rows], display) if not self._served else {}
            results.append(found | (body or {"src": f"result/{model}/{number}"}))
        return _original(display, str(group.input.iloc[0])) | {
            "results": results,
            "scales": {reduction: error_scale(found) for reduction, found in scales.items()},
            "defaults": default_methods(group, self._reference),
        }


def default_methods(group: pd.DataFrame, reference: str) -> list[str]:
    """The methods that one wants to see first: the reference, the best subset, the paper's."""
    best = group[group.subset.eq(True)].sort_values(["reduction", ERROR], ascending=[False, True]).label
    paper = [label for name in _PAPER for label in group.label[group.label.eq(name)]]
    wanted = [reference, *best[:1], *paper[:1], *group.label[:2]]
    return [m for m in dict.fromkeys(wanted) if m in set(group.label)][:3]


def one_cloud(cloud: PointCloud) -> dict[str, Any]:
    """The view of a single cloud, with its own colours and its scalar attributes."""
    rows = _thin(len(cloud), MOST_OF_ONE)
    entry = _original(_Display(cloud.points, rows), cloud.name or "cloud")
    values = {name: np.asarray(v) for name, v in cloud.attributes.items()}
    scalar = {
        n: v for n, v in values.items() if v.ndim == 1 and v.dtype.kind in "biuf" and np.isfinite(v).any()
    }
    fitting = list(scalar)[: max(1, MOST_VALUES // len(rows))]
    entry["columns"] = {
        name: pack_values(np.nan_to_num(scalar[name][rows].astype(float))) for name in fitting
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
    """Rows to show, in a random order that is the same every time: any beginning of them is an even choice."""
    return np.random.default_rng(0).permutation(n_points)[:most]


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
    def tree(self) -> KDTree:
        from scipy.spatial import KDTree  # as for the pictures: compiled kernels take a second to load

        return KDTree(self.points[self.rows])


def _original(display: _Display, name: str) -> dict[str, Any]:
    return {
        "name": name,
        "total": len(display.points),
        "shown": len(display.rows),
        "low": display.low.tolist(),
        "span": display.span.tolist(),
        "up": up_axis(display.points),
        "points": pack(_steps(display.points[display.rows] - display.low, display.span)),
    }


def _heads(cell: pd.Series, arrays: Mapping[str, NDArray[Any]], errors: Vector) -> dict[str, Any]:
    """What the page says of a result before it is drawn."""
    return {
        "method": cell.label,
        "reduction": float(cell.reduction),
        "count": len(arrays["points"]),
        "mean": float(cell[ERROR]) if np.isfinite(cell[ERROR]) else None,
        "p95": float(np.percentile(errors, 95)),
        "max": float(errors.max()),
    }


def _result(arrays: Mapping[str, NDArray[Any]], errors: Vector, display: _Display) -> dict[str, Any]:
    """The arrays of one result for the points that are shown, as the page's script reads them."""
    own = {k: a[display.rows] for k, a in arrays.items() if a.shape == (len(display.points),)}
    found: dict[str, Any] = {"columns": {"error": pack_values(errors)}}
    if "curvature" in own:
        found["columns"]["curvature"] = pack_values(np.nan_to_num(own["curvature"].astype(float)))
    if "labels" in own:
        found["labels"] = pack(own["labels"].astype("<u2"))
    if "feature_mask" in own:
        found["features"] = _pack_mask(own["feature_mask"].astype(bool))
    if "indices" in arrays and len(display.rows) == len(display.points):
        mask = np.zeros(len(display.points), dtype=bool)
        mask[arrays["indices"]] = True
        return found | {"kept": _pack_mask(mask[display.rows])}
    points = arrays["points"].astype(float)
    points = points[_thin(len(points), MOST_POINTS)]
    nearest = np.asarray(display.tree.query(points)[1]).astype("<u4")
    return found | {"points": pack(_steps(points - display.low, display.span)), "nearest": pack(nearest)}
