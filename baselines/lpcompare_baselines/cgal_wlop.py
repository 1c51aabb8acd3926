"""CGAL's weighted locally optimal projection: a random sample, moved to be even and free of noise.

The call includes filling CGAL's point set from Python.
"""

from __future__ import annotations

import numpy as np
from CGAL.CGAL_Point_set_3 import Point_set_3  # pyright: ignore[reportMissingImports]
from CGAL.CGAL_Point_set_processing_3 import wlop_simplify_and_regularize_point_set  # pyright: ignore[reportMissingImports]

from lpcompare.errors import NotApplicable
from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._cgal import point_set
from lpcompare_baselines._guards import check_distinct

TRAITS = Traits(
    family="surface",
    wraps="CGAL wlop_simplify_and_regularize_point_set",
    source="Huang, Li, Zhang, Ascher and Cohen-Or, Consolidation of unorganized point clouds for surface "
    "reconstruction, SIGGRAPH Asia 2009",
    licence="GPL-3.0",
    moves_points=True,
    keeps_attributes=False,
    requires=("CGAL",),
    extra="cgal",
)


def cgal_wlop(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Project a random sample onto the surface that the points suggest.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws the order in which CGAL sees the points.

    Returns
    -------
    Simplification
        New points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for, or the projection leaves the numbers.
    """
    check_distinct(points, target_count)
    moved = Point_set_3()
    percentage = 100 * (target_count + 0.5) / len(points)
    cloud = point_set(points[rng.permutation(len(points))])
    wlop_simplify_and_regularize_point_set(cloud, moved, select_percentage=min(percentage, 100.0))
    result = np.array([(p.x(), p.y(), p.z()) for p in moved.points()]).reshape(-1, 3)
    if not np.isfinite(result).all():
        raise NotApplicable("WLOP's projection diverges on this cloud (coordinates that are not numbers).")
    return Simplification(result + bounding_box_center(points))
