"""CGAL's random simplification: a random share of the points is removed.

The call includes filling CGAL's point set from Python. CGAL's generator cannot be seeded from Python: the
order in which it sees the points is drawn from ours.
"""

from __future__ import annotations

import numpy as np
from CGAL.CGAL_Point_set_processing_3 import random_simplify_point_set  # pyright: ignore[reportMissingImports]

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._cgal import point_set, rows_of

TRAITS = Traits(
    family="random",
    wraps="CGAL random_simplify_point_set",
    source="CGAL Point Set Processing",
    licence="GPL-3.0",
    requires=("CGAL",),
    extra="cgal",
)


def cgal_random(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep ``target_count`` rows, every subset equally likely.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the order in which CGAL sees the points.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    order = rng.permutation(len(points))
    cloud = point_set(points[order])
    # CGAL cuts the number that stays down to an integer: half a point more leaves the right one
    random_simplify_point_set(cloud, 100 * max(len(points) - target_count - 0.5, 0) / len(points))
    indices = np.sort(order[rows_of(cloud)])
    return Simplification(points[indices], indices)
