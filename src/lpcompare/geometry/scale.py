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


def about_center(points: Points) -> Points:
    """``points`` (n, 3) about the center of their bounding box, where single precision costs the fewest digits."""
    return points - bounding_box_center(points)


def normalize(points: Points) -> tuple[Points, Vector, float]:
    """Move a cloud to its centroid and divide it by its root mean square radius.

    Multiplying the input by a power of two leaves the result unchanged to the last bit.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Model units.

    Returns
    -------
    normalized : ndarray, shape (n, 3)
        Mean zero, mean squared radius one; all zero for a cloud without extent.
    center : ndarray, shape (3,)
        Model units.
    scale : float
        Model units per unit of the normalised cloud; 1 for a cloud without extent.
    """
    center = points[0] + (points - points[0]).mean(axis=0)
    centred = points - center
    largest = float(np.abs(centred).max())
    if largest <= 8 * np.finfo(float).eps * float(np.abs(center).max()) or np.ptp(points, axis=0).max() == 0:
        return np.zeros_like(centred), center, 1.0
    scale = largest * float(np.sqrt(np.mean(np.sum((centred / largest) ** 2, axis=1))))
    return centred / scale, center, scale
