"""Figures 4 to 7 of the paper, and the holes, drawn with the report's projections."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from reports.paper.charts import save
from reports.paper.experiments import COMPARED, PICTURED_CLUSTERS, REDUCTIONS, kept_count
from reports.paper.lab import Lab

from lpcompare import LPSimplifier, simplify
from lpcompare.metrics.comparison import Comparison
from lpcompare.report.projections import draw_cloud, draw_mesh, triangulate

_HIGHEST_SHOWN = 98.0
_POINT_SIZE = 7.0


def draw_clusters(lab: Lab, name: str, path: Path) -> None:
    """Fig. 4: the cloud coloured by cluster."""
    figure = Figure(figsize=(5, 5), layout="constrained")
    draw_cloud(figure.subplots(), lab.points(name), labels=_fit(lab, name).labels_, size=_POINT_SIZE)
    save(figure, path)


def draw_curvature(lab: Lab, name: str, path: Path) -> None:
    """Fig. 5: the absolute curvature, and the feature points against the others."""
    figure = Figure(figsize=(9, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    curvature = _fit(lab, name).curvature_.absolute
    highest = float(np.percentile(curvature, _HIGHEST_SHOWN))
    points = lab.points(name)
    draw_cloud(left, points, values=curvature, limits=(0, highest), size=_POINT_SIZE)
    left.set_title("absolute curvature A = |k1| + |k2|", fontsize=10)
    features = _fit(lab, name).feature_mask_
    draw_cloud(right, points, labels=features.astype(np.intp), size=_POINT_SIZE)
    right.set_title(f"feature points: {features.mean():.0%} of the cloud", fontsize=10)
    save(figure, path)


def draw_reduced(lab: Lab, name: str, path: Path) -> None:
    """Figs. 6 and 7: original and reduced clouds, triangulated, shaded above and wireframe below."""
    clouds = {"original": lab.points(name)}
    for reduction in REDUCTIONS:
        kept = _fit(lab, name, reduction).simplification_.points
        clouds[f"{reduction:.0%} removed: {len(kept):,} points"] = kept
    figure = Figure(figsize=(14, 7.4), layout="constrained")
    grid = figure.subplots(2, len(clouds))
    for column, (title, points) in zip(grid.T, clouds.items(), strict=True):
        faces = triangulate(points)
        draw_mesh(column[0], points, faces)
        draw_mesh(column[1], points, faces, wireframe=True)
        column[0].set_title(title, fontsize=10)
    save(figure, path)


def draw_holes(lab: Lab, name: str, path: Path) -> None:
    """Distance of the originals to the nearest kept point at the highest rate, at equal counts."""
    points = lab.points(name)
    target = kept_count(len(points), REDUCTIONS[-1])
    gaps = {}
    for method in COMPARED[:3]:
        kept = simplify(points, target_count=target, method=method, random_state=0).points
        comparison = Comparison(points, kept)
        gaps[method] = 100.0 * comparison.forward_distances / comparison.diagonal
    highest = float(np.percentile(np.concatenate(list(gaps.values())), _HIGHEST_SHOWN))
    figure = Figure(figsize=(13, 4.6), layout="constrained")
    for axes, (method, gap) in zip(figure.subplots(1, len(gaps)), gaps.items(), strict=True):
        draw_cloud(axes, points, values=gap, limits=(0, highest), size=_POINT_SIZE)
        axes.set_title(f"{method}: farthest {gap.max():.2f} % of the diagonal", fontsize=10)
    save(figure, path)


def _fit(lab: Lab, name: str, reduction: float = REDUCTIONS[0]) -> LPSimplifier:
    return lab.fitted(name, "lp_printed", "keep-features", PICTURED_CLUSTERS, reduction, 0)
