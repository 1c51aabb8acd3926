"""Draw baseline.json: the median seconds of every stage, metric and method, on a logarithmic scale.

::

    python reports/benchmarks/draw.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lpcompare.report.tables import markdown_table, number, seconds

FOLDER = Path(__file__).resolve().parent
GROUPS = {"test_stages": "stages", "test_metrics": "metrics", "test_methods": "methods"}
OURS, OTHERS = "#c2410c", "#16324f"

Benchmark = dict[str, Any]


def groups() -> dict[str, list[Benchmark]]:
    """The benchmarks of each suite, the slowest first."""
    found = json.loads((FOLDER / "baseline.json").read_text(encoding="utf-8"))["benchmarks"]
    found.sort(key=lambda b: -b["stats"]["median"])
    return {title: [b for b in found if f"{suite}.py" in b["fullname"]] for suite, title in GROUPS.items()}


def label(benchmark: Benchmark) -> str:
    """The method or the metric, or the stage with its method."""
    test, _, parameter = benchmark["name"].removeprefix("test_").removesuffix("]").partition("[")
    return parameter if test in ("method", "metric") else " ".join(filter(None, (test, parameter)))


def table() -> Iterator[str]:
    """Every benchmark in Markdown."""
    for title, found in groups().items():
        yield from (f"### {title.capitalize()}", "")
        rows = [
            [
                f"`{label(b)}`",
                seconds(b["stats"]["median"]),
                seconds(b["stats"]["iqr"]),
                str(b["stats"]["rounds"]),
                number(b["extra_info"]["plane_error_pct"]) if "plane_error_pct" in b["extra_info"] else "",
            ]
            for b in found
        ]
        heads = [title[:-1], "median", "interquartile range", "rounds", "plane error, %"]
        yield from (*markdown_table(heads, rows), "")


def ratios() -> Iterator[str]:
    """Pairs that were timed in turns, then the cost of a point by the size of the cloud."""
    found = [
        b
        for file in ("filter.json", "uniform.json")
        for b in json.loads((FOLDER / file).read_text(encoding="utf-8"))["benchmarks"]
    ]
    rows = [
        [f"`{b['name'].removeprefix('test_')}`", f"{b['extra_info']['ratio']:.3g}"]
        for b in found
        if "ratio" in b["extra_info"]
    ]
    yield from (*markdown_table(["ours against the reference", "how many times as fast"], rows), "")
    rows = [
        [
            f"`{b['params']['method']}`",
            f"{b['params']['n_points']:,}",
            f"{b['extra_info']['us_per_point']:.1f}",
            f"{b['extra_info']['units']:.1f}",
        ]
        for b in found
        if "us_per_point" in b["extra_info"]
    ]
    heads = ["method", "points", "microseconds a point", "neighbor passes"]
    yield from markdown_table(heads, rows)


def draw(out: Path) -> None:
    """Two columns: stages and metrics, and methods."""
    found = groups()
    figure = Figure(figsize=(11, 0.19 * len(found["methods"]) + 1), layout="constrained")
    left, right = figure.subplots(1, 2)
    _dots(left, [*found["stages"], *found["metrics"]], "stages of ours, and metrics")
    _dots(right, found["methods"], "methods, the call alone")
    FigureCanvasAgg(figure).print_png(out, pil_kwargs={"optimize": True})


def _dots(axes: Axes, found: list[Benchmark], title: str) -> None:
    found = sorted(found, key=lambda b: -b["stats"]["median"])
    for row, benchmark in enumerate(found):
        stats, ours = benchmark["stats"], label(benchmark).startswith("lp_")
        color = OURS if ours else OTHERS
        axes.plot([stats["min"], stats["max"]], [row, row], color=color, alpha=0.4)
        axes.plot(stats["median"], row, "o", color=color, markersize=4)
    axes.set_yticks(range(len(found)), [label(b) for b in found], fontsize=7)
    axes.set_ylim(len(found) - 0.5, -0.5)
    axes.set_xscale("log")
    axes.set_xlabel("seconds: median, least and most")
    axes.set_title(title, fontsize=10)
    axes.grid(axis="x", alpha=0.4)


if __name__ == "__main__":
    draw(FOLDER / "seconds.png")
