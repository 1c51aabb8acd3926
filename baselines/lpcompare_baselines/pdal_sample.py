"""PDAL's Poisson sampling (filters.sample), written from its manual and not yet run against a real PDAL.

Points are taken in file order, each unless a kept one is within a radius. The radius is searched outside the
clock. The call includes starting the program and going through files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_size, surface_spacing
from lpcompare_baselines._guards import check_distinct
from lpcompare_baselines._pdal import translate

TRAITS = Traits(
    wraps="pdal translate, filters.sample",
    source="PDAL, https://pdal.org/stages/filters.sample.html",
    licence="BSD-3-Clause",
    family="spacing",
    exact_count=False,
    programs=("pdal",),
    install="conda install -c conda-forge pdal",
)

_MOST_CALLS = 20
"""Calls of the search: each starts the program."""


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Radius, in model units, whose count is nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are distinct than are asked for.
    """
    check_distinct(points, target_count)
    start = surface_spacing(points, target_count)
    found = search_size(
        lambda radius: len(translate(points, "filters.sample", radius=radius)),
        target_count,
        start,
        max_calls=_MOST_CALLS,
    )
    return {"radius": found}


def pdal_sample(
    points: Points, target_count: int, *, rng: np.random.Generator, radius: float
) -> Simplification:
    """Keep points that are ``radius`` apart.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    radius : float
        In model units.

    Returns
    -------
    Simplification
        A subset of the input, of about ``target_count`` points.
    """
    indices = translate(points, "filters.sample", radius=radius)
    return Simplification(points[indices], indices)
