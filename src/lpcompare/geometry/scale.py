"""Bounding box, diagonal and shift to the centre."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Vector


def bounding_box_diagonal(points: Points) -> float:
    """Length of the diagonal of the axis-aligned bounding box of ``points`` (n, 3), in model units."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def bounding_box_center(points: Points) -> Vector:
    """Centre (3,) of the axis-aligned bounding box of ``points`` (n, 3), in model units."""
    low, high = points.min(axis=0), points.max(axis=0)
    return low + (high - low) / 2
