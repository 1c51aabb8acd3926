"""PDAL's relaxation dart throwing, written from its manual and not yet run against a real PDAL.

filters.relaxationdartthrowing: points in random order, each kept unless a kept one is within a radius, which
shrinks pass by pass until the count is reached. PDAL stops at a radius of .001, so the cloud is scaled to where
the expected spacing is .5 and the first radius 1; it returns fewer points where many coincide. The call
includes starting the program and going through files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import surface_spacing
from lpcompare_baselines._pdal import translate

TRAITS = Traits(
    wraps="pdal translate, filters.relaxationdartthrowing",
    source="PDAL, https://pdal.org/stages/filters.relaxationdartthrowing.html",
    licence="BSD-3-Clause",
    family="spacing",
    exact_count=False,
    programs=("pdal",),
    install="conda install -c conda-forge pdal",
)

_LARGEST_SEED = 2**31


def pdal_dart_throwing(
    points: Points, target_count: int, *, rng: np.random.Generator, decay: float = 0.9
) -> Simplification:
    """Keep points that are as far apart as the count allows, to within a factor of ``decay``.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws PDAL's seed.
    decay : float, optional
        What the radius is multiplied by after each pass.

    Returns
    -------
    Simplification
        A subset of the input, of at most ``target_count`` points.
    """
    scaled = points / (2 * surface_spacing(points, target_count))
    seed = int(rng.integers(_LARGEST_SEED))
    options = {"count": target_count, "radius": 1, "decay": decay, "seed": seed}
    indices = translate(scaled, "filters.relaxationdartthrowing", **options)
    return Simplification(points[indices], indices)
