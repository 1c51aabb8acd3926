"""PDAL's Poisson sampling (filters.sample), written from its manual and not yet run against a real PDAL.

Points are taken in file order, each unless a kept one is within a radius. The radius is searched outside the
clock. The call includes starting the program and going through files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._pdal import translate
from lpcompare_baselines._programs import MOST_CALLS

TRAITS = Traits(
    wraps="pdal translate, filters.sample",
    source="PDAL, https://pdal.org/stages/filters.sample.html",
    licence="BSD-3-Clause",
    family="spacing",
    exact_count=False,
    programs=("pdal",),
    install="conda install -c conda-forge pdal",
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Radius, in model units, whose count is nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are distinct than are asked for.
    """

    def count(radius: float) -> int:
        return len(translate(points, "filters.sample", radius=radius))

    return {"radius": search_spacing(count, points, target_count, max_calls=MOST_CALLS)}


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
