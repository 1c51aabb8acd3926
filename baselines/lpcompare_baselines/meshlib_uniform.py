"""MeshLib's uniform sampling: points in file order, each kept unless a kept one is within a distance.

The distance is searched outside the clock.
"""

from __future__ import annotations

import numpy as np
from meshlib import mrmeshpy  # pyright: ignore[reportMissingImports]

from lpcompare.types import Indices, Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._meshlib import point_cloud, rows_of

TRAITS = Traits(
    wraps="meshlib mrmeshpy.pointUniformSampling",
    source="MeshLib, pointUniformSampling, https://meshlib.io",
    licence="free for non-commercial use",
    family="spacing",
    exact_count=False,
    requires=("meshlib",),
    extra="meshlib",
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Distance, in model units, whose count is nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    return {"distance": search_spacing(lambda d: len(_sample(points, d)), points, target_count)}


def meshlib_uniform(
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
    indices = _sample(points, distance)
    return Simplification(points[indices], indices)


def _sample(points: Points, distance: float) -> Indices:
    settings = mrmeshpy.UniformSamplingSettings()
    settings.distance = distance
    kept = mrmeshpy.pointUniformSampling(point_cloud(points), settings)
    return rows_of(kept)
