"""PDAL's farthest point sampling (filters.fps), written from its manual and not yet run against a real PDAL.

The call includes starting the program and going through files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._guards import check_distinct
from lpcompare_baselines._pdal import translate

TRAITS = Traits(
    wraps="pdal translate, filters.fps",
    source="PDAL, https://pdal.org/stages/filters.fps.html",
    licence="BSD-3-Clause",
    family="spacing",
    programs=("pdal",),
    install="conda install -c conda-forge pdal",
)


def pdal_farthest_point(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep ``target_count`` points, each the farthest from those before it.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the manual names no seed.

    Returns
    -------
    Simplification
        A subset of the input.

    Raises
    ------
    NotApplicable
        Fewer points are distinct than are asked for.
    """
    check_distinct(points, target_count)
    indices = translate(points, "filters.fps", count=target_count)
    return Simplification(points[indices], indices)
