"""MeshLib's iterative sampling: an exact number of points, without a radius, in single precision.

`iterative_sampling` says how it works.
"""

from __future__ import annotations

import numpy as np
from meshlib import mrmeshpy  # pyright: ignore[reportMissingImports]

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._meshlib import point_cloud, rows_of

TRAITS = Traits(
    wraps="meshlib mrmeshpy.pointIterativeSampling",
    source="MeshLib, pointIterativeSampling, https://meshlib.io",
    licence="free for non-commercial use",
    family="spacing",
    requires=("meshlib",),
    extra="meshlib",
)


def meshlib_iterative(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep ``target_count`` points.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    indices = rows_of(mrmeshpy.pointIterativeSampling(point_cloud(points), target_count))
    return Simplification(points[indices], indices)
