"""Pictures of the results of a run: points kept, error maps, triangulated surfaces, curvature."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lpcompare.benchmark.record import Run
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.io.arrays import load_arrays
from lpcompare.report.cells import Cell
from lpcompare.report.clouds3d import input_files
from lpcompare.report.columns import ERROR
from lpcompare.report.projections import draw_cloud, draw_mesh, triangulate
from lpcompare.report.shading import up_axis
from lpcompare.report.wording import number
from lpcompare.types import Points, Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

_AREA = 60_000
"""Points of unit area that cover a cloud in a picture."""


def draw_pictures(run: Run, cells: Sequence[Cell]) -> Iterator[tuple[str, Figure]]:
    """The clouds of one model and reduction, drawn in every way that they allow."""
    from matplotlib.figure import Figure

    with_curvature = [c for c in cells if "curvature" in load_arrays(run.folder / c.cloud)]
    large = [c for c in cells if c.value("n_output") >= 3]
    for what, group in (
        ("kept", cells),
        ("errors", cells),
        ("surfaces", large),
        ("curvature", with_curvature[:1]),
    ):
        if group:
            n_rows, n_columns = grid_shape(len(group) + 1)
            figure = Figure(figsize=(2.3 * n_columns + 1, 2.7 * n_rows), layout="constrained")
            draw_results(figure, run, group, what)
            yield what, figure


def draw_results(figure: Figure, run: Run, cells: Sequence[Cell], what: str) -> None:
    """The original and each result of one model and reduction.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    run : Run
    cells : sequence of Cell
        Results that the run kept, of one model and reduction.
    what : str
        "kept": the points kept; "errors": every original, coloured by its eq. 27 error on one scale;
        "surfaces": triangles through the points kept, shaded; "curvature": every original, coloured by the
        absolute curvature that the method found.
    """
    points = load_arrays(input_files(run)[cells[0].model])["points"].astype(float)
    results = [(cell, load_arrays(run.folder / cell.cloud)) for cell in cells]
    grid = figure.subplots(*grid_shape(len(cells) + 1), squeeze=False).ravel()
    size = float(np.clip(_AREA / len(points), 0.3, 12))
    for axes in grid:
        axes.set_axis_off()
    draw = _painter(what, points, [arrays for _, arrays in results], size)
    draw_cloud(grid[0], points, size=size, up=up_axis(points))
    grid[0].set_title(f"original\n{len(points):,} points", fontsize=9)
    shown = None
    for axes, (cell, arrays) in zip(grid[1:], results, strict=False):
        shown = draw(axes, arrays)
        error = number(cell.value(ERROR))
        axes.set_title(
            f"{plain_text(cell.method)}\n{len(arrays['points']):,} points, error {error} %", fontsize=9
        )
        axes.set_xlim(grid[0].get_xlim())
        axes.set_ylim(grid[0].get_ylim())
    labels = {"errors": "Eq. 27 error [% of diagonal]", "curvature": "Absolute curvature [1 / model unit]"}
    if shown is not None and what in labels:
        figure.colorbar(shown, ax=list(grid), shrink=0.9, label=labels[what], extend="max")


def grid_shape(n_panels: int) -> tuple[int, int]:
    """Rows and columns of a grid at most five wide, as full as can be."""
    n_rows = -(-n_panels // 5)
    return n_rows, -(-n_panels // n_rows)


Painter = Callable[["Axes", Mapping[str, np.ndarray]], "ScalarMappable | None"]


def _painter(what: str, points: Points, results: Sequence[Mapping[str, np.ndarray]], size: float) -> Painter:
    """How one result is drawn."""
    up = up_axis(points)
    if what == "kept":
        return lambda axes, r: draw_cloud(
            axes, r["points"].astype(float), size=min(1.6 * size, 6), up=up, plain="#1f4e79"
        )
    if what == "surfaces":
        return lambda axes, r: draw_mesh(axes, r["points"].astype(float), triangulate(r["points"]), up=up)
    if what == "curvature":
        high = max(float(np.percentile(r["curvature"], 95)) for r in results)
        return lambda axes, r: draw_cloud(
            axes, points, r["curvature"], limits=(0, high), colormap="cividis", size=size, up=up, shaded=False
        )
    high = error_scale(points, results)
    return lambda axes, r: draw_cloud(
        axes, points, percent_errors(points, r), limits=(0, high), size=size, up=up, shaded=False
    )


def error_scale(points: Points, results: Sequence[Mapping[str, np.ndarray]]) -> float:
    """The error in % at the top of a colour scale: the median of the 99th percentiles of the results."""
    return float(np.median([np.percentile(percent_errors(points, r), 99) for r in results]))


def percent_errors(points: Points, arrays: Mapping[str, np.ndarray]) -> Vector:
    """Eq. 27: distance of each original (n,) to the plane of its nearest kept points, % of diagonal."""
    diagonal = bounding_box_diagonal(points)
    return arrays["plane_errors"].astype(float) * (100 / diagonal if diagonal > 0 else 1.0)


def plain_text(text: str) -> str:
    """A name without what matplotlib would read as mathematics, or hide from a legend."""
    return text.replace("$", r"\$").lstrip("_")
