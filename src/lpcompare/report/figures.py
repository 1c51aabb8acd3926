"""The page's charts and clouds as SVG, PDF and PNG for papers, drawn by matplotlib without a display."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from lpcompare.benchmark.record import Run
from lpcompare.benchmark.run_folder import file_name
from lpcompare.files import whole_file
from lpcompare.io.arrays import load_arrays
from lpcompare.report.cells import (
    COSTS,
    ERROR,
    LEVELS,
    RUNTIME,
    axis_title,
    cells,
    choose_reference,
    columns,
    pareto_front,
    perturbation_curves,
    ratios,
    stage_name,
)
from lpcompare.report.clouds3d import error_scale, kept_results, percent_errors
from lpcompare.report.projections import draw_cloud, draw_mesh, triangulate, up_axis
from lpcompare.report.styles import method_styles, stage_styles
from lpcompare.report.tables import number, percent
from lpcompare.types import Column, Points

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

FORMATS = ("svg", "pdf", "png")
_DPI = 200
_AREA = 60_000
"""Points of unit area that cover a cloud in a picture."""

_PICTURES = ("kept", "errors", "surfaces", "curvature")
_BARS = {"errors": "Plane error [% of diagonal]", "curvature": "Curvature [1 / model unit]"}


def write_figures(run: Run, folder: Path, reference: str = "") -> list[Path]:
    """Write every figure of a run, each in every format.

    Parameters
    ----------
    run : Run
    folder : Path
        Created if need be.
    reference : str
        The method that ratios are taken to; by default that of the page.

    Returns
    -------
    list of Path
        The files written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, figure in _figures(run, reference):
        for extension in FORMATS:
            written.append(folder / f"{name}.{extension}")
            _save(figure, written[-1])
    return written


def draw_curves(axes: Axes, table: pd.DataFrame, x_key: str, *, front: bool = False) -> None:
    """Plane error against another column, one line per method, with the range of the repeats."""
    known, styles = COSTS | columns(table), method_styles(table.label.unique())
    judged = table.dropna(subset=[ERROR, x_key]).sort_values("reduction", kind="stable")
    for _, group in judged.groupby("reduction", sort=False) if front else ():
        best = pareto_front(group, x_key, ERROR)
        axes.step(best[x_key], best[ERROR], where="post", c="0.6", lw=1)
    for method, group in judged.groupby("label", sort=False):
        style = styles[str(method)]
        axes.errorbar(
            group[x_key], group[ERROR], xerr=_bars(group, x_key), yerr=_bars(group, ERROR), lw=0.8, ls=":",
            label=plain_text(str(method)), elinewidth=0.8, ms=5, color=style.color, marker=style.marker,
        )  # fmt: skip
    for axis, key in (("x", x_key), ("y", ERROR)):
        if len(judged) and judged[f"{key}_low"].gt(0).all():
            _logarithmic(axes, axis)
    axes.set_xlabel(axis_title(known[x_key]))
    axes.set_ylabel(axis_title(known.get(ERROR, Column("", ERROR))))
    axes.grid(alpha=0.3)


def draw_ratios(axes: Axes, table: pd.DataFrame, reference: str) -> None:
    """Each method's plane error over that of the reference, a mark for each reduction."""
    styles = method_styles(table.label.unique())
    judged = table.assign(ratio=ratios(table, reference, [ERROR])[ERROR]).dropna(subset=["ratio"])
    order = judged.groupby("label", sort=False).ratio.max().sort_values(ascending=False, kind="stable").index
    for place, method in enumerate(order):
        for cell in judged[judged.label.eq(method)].itertuples():
            style = styles[method]
            axes.plot(cell.ratio, place, style.marker, color=style.color, ms=3 + 4 * cell.reduction)
    axes.axvline(1, color="0.6", lw=1)
    axes.set_yticks(range(len(order)), [plain_text(method) for method in order])
    if len(judged):
        _logarithmic(axes, "x")
    axes.set_xlabel(f"Plane error, times {plain_text(reference)}\n(the larger the mark, the more removed)")
    axes.grid(alpha=0.3, axis="x")


def draw_stages(axes: Axes, table: pd.DataFrame) -> None:
    """Seconds per stage of each method; the rest of the call in grey."""
    timed = table.dropna(subset=[RUNTIME]).sort_values(RUNTIME, kind="stable")
    stages = {stage_name(key): timed[key].fillna(0.0) for key in timed if stage_name(key)}
    stages = {name: widths for name, widths in stages.items() if widths.any()}
    left, places = np.zeros(len(timed)), range(len(timed))
    for stage, style in stage_styles(stages).items():
        axes.barh(places, stages[stage], left=left, label=plain_text(stage), color=style.color)
        left = left + stages[stage].to_numpy()
    axes.barh(places, (timed[RUNTIME] - left).clip(lower=0), left=left, label="not told apart", color="0.7")
    axes.set_yticks(places, [plain_text(method) for method in timed.label])
    axes.set_xlabel("Seconds")
    axes.legend(fontsize=7, loc="lower right")


def draw_results(figure: Figure, run: Run, model: str, table: pd.DataFrame, what: str) -> None:
    """The original and each result of one model and reduction.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    run : Run
    model : str
    table : DataFrame
        Cells whose results the run kept, of one model and reduction.
    what : str
        "kept": the points kept; "errors": every original, coloured by its plane error on one scale;
        "surfaces": triangles through the points kept, shaded; "curvature": every original, coloured by the
        absolute curvature that the method found.
    """
    points = load_arrays(kept_results(run, table)[model][0])["points"].astype(float)
    results = [load_arrays(run.folder / name) for name in table.cloud]
    grid = figure.subplots(*grid_shape(len(table) + 1), squeeze=False).ravel()
    size, up = float(np.clip(_AREA / len(points), 0.3, 12)), up_axis(points)
    for axes in grid:
        axes.set_axis_off()
    draw_cloud(grid[0], points, size=size, up=up)
    grid[0].set_title(f"original\n{len(points):,} points", fontsize=9)
    shown, high = None, _top(what, points, results)
    for axes, cell, arrays in zip(grid[1:], table.to_dict("records"), results, strict=False):
        shown = _draw_result(axes, what, points, arrays, high, {"size": size, "up": up})
        title = (
            f"{plain_text(cell['label'])}\n{len(arrays['points']):,} points, error {number(cell[ERROR])} %"
        )
        axes.set_title(title, fontsize=9)
        axes.set(xlim=grid[0].get_xlim(), ylim=grid[0].get_ylim())
    if shown is not None and what in _BARS:
        bar = figure.colorbar(shown, ax=list(grid), shrink=0.9, extend="max")
        bar.set_label(_BARS[what], fontsize=8)


def results_still(run: Run, model: str, table: pd.DataFrame) -> str:
    """The errors of some results as a PNG in base64, for a page."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.4 * (len(table) + 1) + 1, 3.0), layout="constrained")
    draw_results(figure, run, model, table, "errors")
    return _encoded(figure)


def cloud_still(points: Points) -> str:
    """A cloud as a PNG in base64, for a page; a large one is thinned."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 4), layout="constrained")
    shown = points[:: max(1, len(points) // _AREA)]
    draw_cloud(figure.subplots(), shown, size=float(np.clip(_AREA / len(shown), 0.3, 12)), up=up_axis(points))
    return _encoded(figure)


def grid_shape(n_panels: int) -> tuple[int, int]:
    """Lines and columns of a grid at most five wide, as full as can be."""
    n_lines = -(-n_panels // 5)
    return n_lines, -(-n_panels // n_lines)


def plain_text(text: str) -> str:
    """A name without what matplotlib would read as mathematics, or hide from a legend."""
    return text.replace("$", r"\$").lstrip("_")


def _figures(run: Run, reference: str) -> Iterator[tuple[str, Figure]]:
    table = cells(run.frame)
    table = table[table.n_ok > 0]
    reference = reference or choose_reference(table)
    kept = kept_results(run, table)
    for name, group in table.groupby("input", sort=False):
        largest = group[group.reduction.eq(group.reduction.max())]
        for what, figure in _charts(group, largest, reference):
            yield f"{file_name(str(name))}-{what}", figure
        if name in kept:
            shown = largest[largest.index.isin(kept[str(name)][1].index)].dropna(subset=[ERROR])
            for what, figure in _pictures(run, str(name), shown.sort_values(ERROR, kind="stable")):
                yield f"{file_name(str(name))}-{what}", figure
    yield from _perturbation_figures(run)


def _charts(group: pd.DataFrame, largest: pd.DataFrame, reference: str) -> Iterator[tuple[str, Figure]]:
    from matplotlib.figure import Figure

    for what, x_key in (("error-runtime", RUNTIME), ("error-points", "n_output")):
        figure = Figure(figsize=(6.4, 4.4), layout="constrained")
        draw_curves(figure.subplots(), group, x_key, front=x_key == RUNTIME)
        figure.legend(loc="outside right upper", fontsize=7)
        yield what, figure
    tall = (6.4, 1.2 + 0.28 * group.label.nunique())
    figure = Figure(figsize=tall, layout="constrained")
    draw_ratios(figure.subplots(), group, reference)
    yield "ratio", figure
    figure = Figure(figsize=tall, layout="constrained")
    draw_stages(figure.subplots(), largest)
    yield "stages", figure


def _pictures(run: Run, model: str, table: pd.DataFrame) -> Iterator[tuple[str, Figure]]:
    """The clouds of one model and reduction, drawn in every way that they allow."""
    from matplotlib.figure import Figure

    curved = [bool(load_arrays(run.folder / name).keys() & {"curvature"}) for name in table.cloud]
    groups = {"surfaces": table[table.n_output >= 3], "curvature": table[curved].iloc[:1]}
    for what in _PICTURES:
        group = groups.get(what, table)
        if group.empty:
            continue
        n_lines, n_columns = grid_shape(len(group) + 1)
        figure = Figure(figsize=(2.3 * n_columns + 1, 2.7 * n_lines), layout="constrained")
        draw_results(figure, run, model, group, what)
        share = f"{percent(table.reduction.iloc[0])} of the points removed"
        figure.suptitle(f"{plain_text(model)}, {share}", fontsize=10)
        yield what, figure


def _top(what: str, points: Points, results: list[dict[str, np.ndarray]]) -> float:
    """The value at the top of the colour scale of all results."""
    if what == "errors":
        return error_scale([percent_errors(Path("A result"), arrays, points) for arrays in results])
    return max(float(np.percentile(r["curvature"], 95)) for r in results) if what == "curvature" else 0.0


def _draw_result(
    axes: Axes, what: str, points: Points, arrays: Mapping[str, np.ndarray], high: float, style: dict
) -> ScalarMappable | None:
    own = arrays["points"].astype(float)
    if what == "kept":
        return draw_cloud(axes, own, **style | {"size": min(1.6 * style["size"], 6)}, plain="#1f4e79")
    if what == "surfaces":
        return draw_mesh(axes, own, triangulate(own), up=style["up"])
    if what == "curvature":
        values, colormap = arrays["curvature"], "cividis"
    else:
        values, colormap = percent_errors(Path("A result"), arrays, points), "viridis"
    return draw_cloud(axes, points, values, limits=(0, high), colormap=colormap, shaded=False, **style)


def _perturbation_figures(run: Run) -> Iterator[tuple[str, Figure]]:
    """A figure for each model and reduction, every kind of perturbation side by side."""
    from matplotlib.figure import Figure

    curves, styles = perturbation_curves(run.frame), method_styles(run.frame.label.unique())
    for (model, reduction), group in curves.groupby(level=[0, 1], sort=False) if len(curves) else ():
        kinds = group.index.unique("kind")
        figure = Figure(figsize=(1.8 + 2.8 * len(kinds), 3.4), layout="constrained")
        panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
        for axes, kind in zip(panels, kinds, strict=True):
            for method, curve in group.loc[(model, reduction, kind)].iterrows():
                look = {"color": styles[str(method)].color, "marker": styles[str(method)].marker}
                axes.plot(curve.dropna(), label=plain_text(str(method)), lw=0.8, ms=5, **look)
            axes.set_xlabel(LEVELS.get(kind, str(kind)).replace(": ", "\n"))
            axes.grid(alpha=0.3)
        if group.min(axis=None) > 0:
            _logarithmic(panels[0], "y")
        panels[0].set_ylabel("Plane error, % of diagonal")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", fontsize=7)
        yield f"{file_name(model)}-perturbed-{reduction:g}", figure


def _logarithmic(axes: Axes, name: str) -> None:
    """A logarithmic axis with plain numbers: few on a long axis, more on a short one."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set(**{f"{name}scale": "log"})
    axis = axes.xaxis if name == "x" else axes.yaxis
    low, high = axis.get_view_interval()
    few, more = (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=(1.0,) if high / low > 200 else few if high / low > 7 else more))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _bars(table: pd.DataFrame, key: str) -> np.ndarray:
    """Lengths (2, n) of the bars from the medians down to the smallest and up to the largest repeat."""
    return np.array([table[key] - table[f"{key}_low"], table[f"{key}_high"] - table[key]])


def _encoded(figure: Figure) -> str:
    picture = BytesIO()
    figure.savefig(picture, format="png", dpi=100, metadata={"Software": None})
    return base64.b64encode(picture.getvalue()).decode("ascii")


def _save(figure: Figure, path: Path) -> None:
    """Write a figure whole or not at all, the same bytes each time."""
    from matplotlib import rc_context

    dated = {"svg": "Date", "pdf": "CreationDate"}.get(path.suffix[1:])
    with whole_file(path) as part, rc_context({"svg.hashsalt": "lpcompare", "svg.fonttype": "path"}):
        figure.savefig(part, format=path.suffix[1:], dpi=_DPI, metadata={dated: None} if dated else {})
