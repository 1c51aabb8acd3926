"""The page's charts and clouds as SVG, PDF and PNG for papers, drawn by matplotlib without a display."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lpcompare.benchmark.inputs import file_name
from lpcompare.benchmark.record import Run
from lpcompare.files import whole_file
from lpcompare.report.cells import Cell, distinct, gather_cells, pareto_front
from lpcompare.report.charts import choose_reference, stage_names
from lpcompare.report.clouds3d import has_cloud, input_files
from lpcompare.report.columns import ERROR, RUNTIME, headings
from lpcompare.report.damage import LEVELS, Damage, gather_damage
from lpcompare.report.pictures import draw_pictures, plain_text
from lpcompare.report.styles import Style, method_styles, stage_styles
from lpcompare.report.wording import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = ("svg", "pdf", "png")
_DPI = 200


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


def draw_curves(axes: Axes, cells: Sequence[Cell], x_key: str, *, front: bool = False) -> None:
    """Eq. 27 error against another column, one line per method, with the range of the repeats."""
    known = headings({key for cell in cells for key in cell.values})
    styles = method_styles(distinct(cells, "method"))
    judged = [c for c in cells if ERROR in c.values and x_key in c.values]
    if front:
        for reduction in distinct(judged, "reduction"):
            best = pareto_front([c for c in judged if c.reduction == reduction], x_key, ERROR)
            axes.step(
                [c.value(x_key) for c in best], [c.value(ERROR) for c in best], where="post", c="0.6", lw=1
            )
    for method in distinct(judged, "method"):
        group = sorted((c for c in judged if c.method == method), key=lambda c: c.reduction)
        x, y = (np.array([c.value(key) for c in group]) for key in (x_key, ERROR))
        axes.errorbar(
            x, y, xerr=_bars(group, x_key), yerr=_bars(group, ERROR), label=plain_text(method), lw=0.8,
            ls=":", elinewidth=0.8, ms=5, color=styles[method].color, marker=styles[method].marker,
        )  # fmt: skip
    for axis, key in (("x", x_key), ("y", ERROR)):
        if judged and all(c.values[key].low > 0 for c in judged):
            _logarithmic(axes, axis)
    axes.set_xlabel(known[x_key].label if x_key in known else x_key)
    axes.set_ylabel(known[ERROR].label if ERROR in known else ERROR)
    axes.grid(alpha=0.3)


def draw_ratios(axes: Axes, cells: Sequence[Cell], reference: str) -> None:
    """Each method's eq. 27 error over that of the reference, a mark for each reduction."""
    base = {c.reduction: c.value(ERROR) for c in cells if c.method == reference and ERROR in c.values}
    styles = method_styles(distinct(cells, "method"))
    judged = [c for c in cells if ERROR in c.values and base.get(c.reduction)]
    worst = {m: max(c.value(ERROR) / base[c.reduction] for c in judged if c.method == m)
             for m in distinct(judged, "method")}  # fmt: skip
    places = {method: i for i, method in enumerate(sorted(worst, key=lambda m: -worst[m]))}
    for cell in judged:
        style = styles[cell.method]
        ratio, size = cell.value(ERROR) / base[cell.reduction], 3 + 4 * cell.reduction
        axes.plot(ratio, places[cell.method], style.marker, color=style.color, ms=size)
    axes.axvline(1, color="0.6", lw=1)
    axes.set_yticks(list(places.values()), [plain_text(method) for method in places])
    if judged and min(c.value(ERROR) for c in judged) > 0:
        _logarithmic(axes, "x")
    axes.set_xlabel(f"Eq. 27 error, times {plain_text(reference)}\n(the larger the mark, the more removed)")
    axes.grid(alpha=0.3, axis="x")


def draw_stages(axes: Axes, cells: Sequence[Cell]) -> None:
    """Seconds per stage of each method; the rest of the call in grey."""
    timed = sorted((c for c in cells if RUNTIME in c.values), key=lambda c: c.value(RUNTIME))
    left = np.zeros(len(timed))
    for stage, style in stage_styles(stage_names(cells)).items():
        widths = np.array([cell.timings.get(stage, 0.0) for cell in timed])
        axes.barh(range(len(timed)), widths, left=left, label=plain_text(stage), color=style.color)
        left += widths
    rest = np.clip(np.array([cell.value(RUNTIME) for cell in timed]) - left, 0, None)
    axes.barh(range(len(timed)), rest, left=left, label="not told apart", color="0.7")
    axes.set_yticks(range(len(timed)), [plain_text(cell.method) for cell in timed])
    axes.set_xlabel("Seconds")
    axes.legend(fontsize=7, loc="lower right")


def draw_damage(axes: Axes, damage: Damage, styles: Mapping[str, Style]) -> None:
    """Eq. 27 error against the clean cloud over the amount of damage to the input, one line per method."""
    for method, curve in damage.curves.items():
        look = {"color": styles[method].color, "marker": styles[method].marker, "lw": 0.8, "ms": 5}
        axes.plot(list(curve), list(curve.values()), label=plain_text(method), **look)
    if min(damage.errors) > 0:
        _logarithmic(axes, "y")
    axes.set_xlabel(LEVELS[damage.kind].replace(": ", "\n"))
    axes.grid(alpha=0.3)


def _figures(run: Run, reference: str) -> Iterator[tuple[str, Figure]]:
    from matplotlib.figure import Figure

    cells = [cell for cell in gather_cells(run.records) if cell.ok]
    reference = reference or choose_reference(cells)
    for model in distinct(cells, "model"):
        group = [cell for cell in cells if cell.model == model]
        largest = max(cell.reduction for cell in group)
        for name, x_key, front in (("error-runtime", RUNTIME, True), ("error-points", "n_output", False)):
            figure = Figure(figsize=(6.4, 4.4), layout="constrained")
            draw_curves(figure.subplots(), group, x_key, front=front)
            figure.legend(loc="outside right upper", fontsize=7)
            yield f"{file_name(model)}-{name}", figure
        figure = Figure(figsize=(6.4, 1.2 + 0.28 * len(distinct(group, "method"))), layout="constrained")
        draw_ratios(figure.subplots(), group, reference)
        yield f"{file_name(model)}-ratio", figure
        figure = Figure(figsize=(6.4, 1.2 + 0.28 * len(distinct(group, "method"))), layout="constrained")
        draw_stages(figure.subplots(), [c for c in group if c.reduction == largest])
        yield f"{file_name(model)}-stages", figure
        shown = [c for c in group if c.reduction == largest and has_cloud(run, c) and ERROR in c.values]
        if model in input_files(run):
            for name, figure in draw_pictures(run, sorted(shown, key=lambda c: c.value(ERROR))):
                figure.suptitle(f"{plain_text(model)}, {percent(largest)} of the points removed", fontsize=10)
                yield f"{file_name(model)}-{name}", figure
    yield from _damage_figures(run)


def _damage_figures(run: Run) -> Iterator[tuple[str, Figure]]:
    """A figure for each model and reduction, every kind of damage side by side."""
    from matplotlib.figure import Figure

    styles = method_styles(distinct(gather_cells(run.records), "method"))
    groups: dict[str, list[Damage]] = {}
    for damage in gather_damage(run.records):
        groups.setdefault(f"{file_name(damage.model)}-damage-{damage.reduction:g}", []).append(damage)
    for name, group in groups.items():
        figure = Figure(figsize=(1.8 + 2.8 * len(group), 3.4), layout="constrained")
        panels = figure.subplots(1, len(group), sharey=True, squeeze=False)[0]
        for axes, damage in zip(panels, group, strict=True):
            draw_damage(axes, damage, styles)
        panels[0].set_ylabel("Eq. 27 error, % of diagonal")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", fontsize=7)
        yield name, figure


def _logarithmic(axes: Axes, name: str) -> None:
    """A logarithmic axis with plain numbers: few on a long axis, more on a short one."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set(**{f"{name}scale": "log"})
    axis = axes.xaxis if name == "x" else axes.yaxis
    low, high = axis.get_view_interval()
    digits = (
        (1.0,)
        if high / low > 200
        else (1.0, 2.0, 5.0)
        if high / low > 7
        else (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
    )
    axis.set_major_locator(LogLocator(subs=digits))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _bars(cells: Sequence[Cell], key: str) -> np.ndarray:
    """Lengths (2, n) of the bars from the medians down to the smallest and up to the largest repeat."""
    spans = [cell.values[key] for cell in cells]
    return np.array([[s.median - s.low for s in spans], [s.high - s.median for s in spans]])


def _save(figure: Figure, path: Path) -> None:
    """Write a figure whole or not at all, the same bytes each time."""
    from matplotlib import rc_context

    dated = {"svg": "Date", "pdf": "CreationDate"}.get(path.suffix[1:])
    with whole_file(path) as part, rc_context({"svg.hashsalt": "lpcompare", "svg.fonttype": "path"}):
        figure.savefig(part, format=path.suffix[1:], dpi=_DPI, metadata={dated: None} if dated else {})
