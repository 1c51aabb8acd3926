"""CGAL's hierarchy simplification: clusters are split until small and flat, then each keeps one point.

A cluster is split while it has more points than a limit or its surface variation is above a threshold, so
that curved places keep more. The threshold is searched outside the clock; the limit is three times the mean
number of points per kept one. Groups of up to three points are flat and stay together, so that counts near
that of the input cannot be had. The call includes filling CGAL's point set from Python.
"""

from __future__ import annotations

import numpy as np
from CGAL.CGAL_Point_set_processing_3 import hierarchy_simplify_point_set  # pyright: ignore[reportMissingImports]

from lpcompare.types import Indices, Points, Simplification, Traits
from lpcompare_baselines._calibration import search_size
from lpcompare_baselines._cgal import MOST_CALLS, point_set, rows_of
from lpcompare_baselines._guards import check_distinct

TRAITS = Traits(
    family="clustering",
    wraps="CGAL hierarchy_simplify_point_set",
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    licence="GPL-3.0",
    exact_count=False,
    requires=("CGAL",),
    extra="cgal",
)

_LARGEST_VARIATION = 1 / 3
_USUAL_VARIATION = 0.003
_SIZE_OVER_MEAN = 3


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Largest surface variation, from 0 to 1/3, that gives about ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    check_distinct(points, target_count)

    def count(variation: float) -> int:
        return len(_hierarchy(points, target_count, variation))

    variation = search_size(count, target_count, _USUAL_VARIATION, max_calls=MOST_CALLS)
    return {"max_variation": min(variation, _LARGEST_VARIATION)}


def cgal_hierarchy(
    points: Points, target_count: int, *, rng: np.random.Generator, max_variation: float
) -> Simplification:
    """Keep the point nearest to the mean of each cluster.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    max_variation : float
        Largest surface variation of a cluster; `calibrate` finds it.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    indices = _hierarchy(points, target_count, max_variation)
    return Simplification(points[indices], indices)


def _hierarchy(points: Points, target_count: int, variation: float) -> Indices:
    cloud = point_set(points)
    size = max(2, _SIZE_OVER_MEAN * len(points) // target_count)
    hierarchy_simplify_point_set(cloud, size, min(variation, _LARGEST_VARIATION))
    return rows_of(cloud)
