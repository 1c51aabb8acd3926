"""Draw the picture of the README from a run; docs/gallery.py makes those of its page.

::

    lpcompare run --model bunny --repeats 2 --out reports/local/bunny
    python reports/pictures/draw.py reports/local/bunny
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from lpcompare.benchmark.record import load_run
from lpcompare.io.arrays import load_arrays
from lpcompare.report.cells import ERROR, cells
from lpcompare.report.clouds3d import error_scale, kept_results, percent_errors
from lpcompare.report.projections import draw_cloud
from lpcompare.report.tables import number

METHODS = ("lp_printed", "poisson_disk", "lp_uniform")
FOLDER = Path(__file__).parent


def draw_bunny(run_folder: Path, out: Path) -> None:
    """The original beside three methods: what is kept above, the error of every original below."""
    run = load_run(run_folder)
    table = cells(run.frame)
    (file, kept), *_ = kept_results(run, table[table.reduction.eq(table.reduction.max())]).values()
    kept = kept.set_index("label").loc[list(METHODS)]
    points = load_arrays(file)["points"]
    results = {method: load_arrays(run.folder / name) for method, name in kept.cloud.items()}
    errors = {method: percent_errors(file, result, points) for method, result in results.items()}
    high = error_scale(list(errors.values()))
    figure = Figure(figsize=(11, 5.6), layout="constrained")
    grid = figure.subplots(2, len(METHODS) + 1)
    shown = draw_cloud(grid[0, 0], points, size=2.4)
    grid[0, 0].set_title(f"original\n{len(points):,} points", fontsize=11)
    grid[1, 0].set_axis_off()
    for column, (method, result) in enumerate(results.items(), start=1):
        draw_cloud(grid[0, column], result["points"], size=3, plain="#16324f")
        shown = draw_cloud(grid[1, column], points, errors[method], limits=(0, high), size=2.4, shaded=False)
        error = number(kept.at[method, ERROR])
        grid[0, column].set_title(f"{method}\n{len(result['points']):,} points, error {error} %", fontsize=11)
        for axes in grid[:, column]:
            axes.set_xlim(grid[0, 0].get_xlim())
            axes.set_ylim(grid[0, 0].get_ylim())
    bar = figure.colorbar(shown, cax=grid[1, 0].inset_axes((0.62, 0.1, 0.09, 0.8)), extend="max")
    bar.ax.yaxis.set_ticks_position("left")
    bar.set_label("Eq. 27 error of each original point\n[% of the bounding-box diagonal]", labelpad=-80)
    _save_small(figure, out)


def _save_small(figure: Figure, out: Path) -> None:
    """A PNG of 256 colours."""
    figure.set_dpi(110)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").quantize(256).save(out, optimize=True)


if __name__ == "__main__":
    draw_bunny(Path(sys.argv[1]), FOLDER / "bunny.png")
