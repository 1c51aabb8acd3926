"""VTK's Poisson disk sampling of the points: no two kept ones are nearer than a radius.

The radius is searched outside the clock.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_spacing
from lpcompare_baselines._vtk import finest_length, poisson_disk

TRAITS = Traits(
    wraps="vtk vtkPoissonDiskSampler",
    source="Schroeder, Martin and Lorensen, The Visualization Toolkit, 4th edition, 2006",
    licence="BSD-3-Clause",
    family="spacing",
    exact_count=False,
    requires=("vtkmodules",),
    extra="vtk",
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Radius, in model units, whose count is nearest to ``target_count``.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """
    finest = finest_length(points)

    def count(radius: float) -> int:
        return len(poisson_disk(points, radius))

    return {"radius": search_spacing(count, points, target_count, finest=finest, smallest=finest)}


def vtk_poisson_disk(
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
    indices = poisson_disk(points, radius)
    return Simplification(points[indices], indices)
