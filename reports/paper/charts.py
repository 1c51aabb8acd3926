"""Figures 8 and 9 of the paper, drawn from the measured tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from reports.paper.published import counterpart
from reports.paper.rows import Rows, distinct, values, where

_STAGES = {"normals": "#0072b2", "clustering": "#e69f00", "selection": "#009e73"}
_RATES = {"0.7": "#0072b2", "0.8": "#e69f00", "0.9": "#d55e00"}


def draw_seconds(rows: Rows, model: str, path: Path) -> None:
    """Fig. 8: mean seconds of each stage against K, ours beside the paper's, on a logarithmic scale."""
    rows, paper = where(rows, model=model), counterpart(model)
    clusters = distinct(rows, "n_clusters")
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True) if paper else [figure.subplots()]
    for stage, color in _STAGES.items():
        ours = [values(rows, f"{stage}_s", n_clusters=k).mean() for k in clusters]
        axes[0].plot(clusters, ours, "o-", color=color, label=stage)
        if paper:
            theirs = np.mean([rate[stage] for rate in paper["seconds"].values()], axis=0)
            axes[1].plot(clusters, theirs, "o-", color=color, label=stage)
    axes[0].set(title="measured here", ylabel="seconds, mean over the rates", yscale="log")
    if paper:
        axes[1].set(title="Leal et al. 2017, fig. 8 (other machine)")
    for one in axes:
        one.set_xlabel("clusters K")
        one.grid(alpha=0.3)
    axes[0].legend(frameon=False)
    save(figure, path)


def draw_errors(rows: Rows, model: str, path: Path) -> None:
    """Fig. 9: eq. 27 error against K for each reading and retention; bands span the seeds."""
    rows = where(rows, model=model)
    readings, retentions = distinct(rows, "reading"), distinct(rows, "retention")
    figure = Figure(figsize=(9, 6.4), layout="constrained")
    grid = figure.subplots(len(readings), len(retentions), sharex=True, sharey="row", squeeze=False)
    for axes_row, reading in zip(grid, readings, strict=True):
        for axes, retention in zip(axes_row, retentions, strict=True):
            _draw_curves(axes, where(rows, reading=reading, retention=retention))
            axes.set_title(f"{reading}, {retention}", fontsize=10)
        axes_row[0].set_ylabel("eq. 27 error, % of diagonal")
        axes_row[0].set_ylim(bottom=0)  # once all curves of the row are drawn: it ends the scaling to them
    for axes in grid[-1]:
        axes.set_xlabel("clusters K")
    grid[0][0].legend(frameon=False, title="reduction")
    save(figure, path)


def _draw_curves(axes, rows: Rows) -> None:
    for rate in distinct(rows, "reduction"):
        clusters = distinct(rows, "n_clusters")
        seeds = [values(rows, "plane_error_k8_pct", reduction=rate, n_clusters=k) for k in clusters]
        k = [int(c) for c in clusters]
        axes.plot(k, [s.mean() for s in seeds], "o-", color=_RATES[rate], label=f"{float(rate):.0%}")
        axes.fill_between(
            k, [s.min() for s in seeds], [s.max() for s in seeds], color=_RATES[rate], alpha=0.2, lw=0
        )
    axes.grid(alpha=0.3)


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, the same bytes for the same figure."""
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=110, metadata={"Software": None})
