"""Holes in a reduced cloud: how large they are, and whether they lie in the middle of the clusters."""

from __future__ import annotations

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Indices, Points, Vector

_WORST_SHARE = 0.01
_WIDE = 3.0


def describe_holes(original: Points, kept: Points, labels: Indices) -> dict[str, float]:
    """Distances of the originals to the nearest kept point, and where the largest of them lie.

    Parameters
    ----------
    original : ndarray, shape (n, 3)
    kept : ndarray, shape (m, 3)
    labels : ndarray of int, shape (n,)
        Cluster of each original.

    Returns
    -------
    dict of str to float
        ``gap_mean_pct`` and ``gap_max_pct`` in % of the bounding-box diagonal; ``wide_gap_pct``, the % of
        originals that are farther from a kept point than three times the median spacing of the kept points;
        ``central_pct``, the % of the worst-covered hundredth of the originals that lie in the inner half of
        their cluster (50 where holes do not care about clusters).
    """
    comparison = Comparison(original, kept)
    gaps = comparison.forward_distances
    spacing = comparison.simplified_neighbors.query(comparison.simplified, 2)[0][:, -1]
    worst = np.argsort(-gaps, kind="stable")[: max(1, int(_WORST_SHARE * len(gaps)))]
    return {
        "gap_mean_pct": comparison.percent(float(gaps.mean())),
        "gap_max_pct": comparison.percent(float(gaps.max())),
        "wide_gap_pct": 100.0 * float(np.mean(gaps > _WIDE * np.median(spacing))),
        "central_pct": 100.0 * float(np.mean(_depth(original, labels)[worst] < 0.5)),
    }


def _depth(points: Points, labels: Indices) -> Vector:
    """Rank of each point's distance to the centroid of its cluster, from 0 (the centre) to 1 (the rim)."""
    depth = np.empty(len(points))
    for label in np.unique(labels):
        rows = np.flatnonzero(labels == label)
        distances = np.linalg.norm(points[rows] - points[rows].mean(axis=0), axis=1)
        depth[rows] = np.argsort(np.argsort(distances, kind="stable"), kind="stable") / max(1, len(rows) - 1)
    return depth
