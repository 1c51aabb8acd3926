"""CloudCompare's spatial subsampling, by its command line: no two kept points are nearer than a distance.

The distance is searched outside the clock. The call includes starting the program and going through files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._cloudcompare import subsample
from lpcompare_baselines._programs import MOST_CALLS

TRAITS = Traits(
    wraps="CloudCompare -SS SPATIAL",
    source="CloudCompare, https://www.cloudcompare.org",
    licence="GPL-2.0-or-later",
    family="spacing",
    exact_count=False,
    programs=("CloudCompare",),
    install="apt install cloudcompare, or from https://www.cloudcompare.org",
)

_FINEST = 2e-6
"""The smallest distance that is tried, as a share of the diagonal: single precision tells no less apart."""


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Distance, in model units, whose count is nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """
    finest = _FINEST * bounding_box_diagonal(points)

    def count(distance: float) -> int:
        return len(subsample(points, "SPATIAL", distance))

    limits = {"finest": finest, "smallest": finest, "max_calls": MOST_CALLS}
    return {"distance": search_spacing(count, points, target_count, **limits)}


def cloudcompare_spatial(
    points: Points, target_count: int, *, rng: np.random.Generator, distance: float
) -> Simplification:
    """Keep points that are ``distance`` apart.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    distance : float
        In model units.

    Returns
    -------
    Simplification
        A subset of the input, of about ``target_count`` points.
    """
    indices = subsample(points, "SPATIAL", distance)
    return Simplification(points[indices], indices)
