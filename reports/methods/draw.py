"""Draw who wins by which measure: every method's place by every measure of the study.

::

    python reports/methods/draw.py
"""

from __future__ import annotations

import runpy
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

FOLDER = Path(__file__).resolve().parent
STRENGTHS = runpy.run_path(str(FOLDER / "strengths.py"))
BEST = 3
"""Places that are written into their squares."""


def draw(out: Path) -> None:
    """Methods from the best place over all measures downwards; a column for each measure, the first for all."""
    found = STRENGTHS["study"](FOLDER)
    places = found.places[["all", *found.keys]]
    figure = Figure(figsize=(9.5, 0.19 * len(places) + 2.6), layout="constrained")
    axes = figure.subplots()
    image = axes.imshow(places, cmap="RdYlBu_r", aspect="auto", vmin=1, vmax=len(places))
    for row, method in enumerate(places.index):
        for column, key in enumerate(places):
            if (place := places.at[method, key]) <= BEST:
                axes.text(column, row, place, ha="center", va="center", color="white", fontsize=8)
    titles = ["all of them", *(STRENGTHS["MEASURES"][key] for key in found.keys)]
    axes.set_xticks(range(len(titles)), titles, rotation=60, ha="left", rotation_mode="anchor", fontsize=8)
    axes.xaxis.tick_top()
    axes.axvline(0.5, color="white", linewidth=3)
    axes.set_yticks(range(len(places)), places.index, fontsize=7)
    for text in axes.get_yticklabels():
        if text.get_text().startswith("lp_"):
            text.set_fontweight("bold")
    bar = figure.colorbar(image, ax=axes, shrink=0.5, ticks=[1, *range(10, len(places), 10)])
    bar.ax.invert_yaxis()
    bar.set_label("place by the mean rank")
    FigureCanvasAgg(figure).print_png(out, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    draw(FOLDER / "places.png")
