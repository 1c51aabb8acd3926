"""CGAL point sets from and to numpy arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from CGAL.CGAL_Kernel import Point_3  # pyright: ignore[reportMissingImports]
from CGAL.CGAL_Point_set_3 import Point_set_3  # pyright: ignore[reportMissingImports]

from lpcompare.geometry.scale import about_center
from lpcompare.types import Indices, Points

MOST_CALLS = 20
"""Calls of a search: each fills a point set anew, point by point."""


def point_set(points: Points) -> Any:
    """The points as a CGAL point set, about the centre of their bounding box."""
    cloud = Point_set_3()
    cloud.reserve(len(points))
    for x, y, z in about_center(points).tolist():
        cloud.insert(Point_3(x, y, z))
    return cloud


def rows_of(cloud: Any) -> Indices:
    """Rows of the input that were not removed, ascending."""
    return np.sort(np.fromiter(cloud.indices(), dtype=np.intp))
