"""Whether what a method returned can be believed."""

from __future__ import annotations

import numpy as np

from lpcompare.types import PointCloud, Simplification, Traits

_FORGIVEN = 0.01
"""Share of a promised count that may be missing: a damaged mesh can withhold the last points."""


def fault(result: object, before: PointCloud, after: PointCloud, target: int, traits: Traits) -> str:
    """What is wrong with a result, in a sentence; empty when nothing is.

    Parameters
    ----------
    result : object
        What the method returned.
    before, after : PointCloud
        The input as it was given, and as the method left it.
    target : int
        Points asked for.
    traits : Traits
        What the method promises.
    """
    if _changed(before, after):
        return "The method changed its input."
    if not isinstance(result, Simplification):
        return f"The method returned a {type(result).__name__}, not a Simplification."
    points = result.points
    if not isinstance(points, np.ndarray) or points.ndim != 2 or points.shape[1] != 3:
        return f"The points have shape {np.shape(points)}; it must be (m, 3)."
    if points.dtype != np.float64:
        return f"The points are {points.dtype}; they must be float64."
    return _count_fault(len(points), len(before), target, traits) or _value_fault(result, before, traits)


def shortfall(count: int, target: int, traits: Traits) -> str:
    """A word on up to 1 % fewer points than promised, a result all the same; empty when there is none."""
    if traits.exact_count and count < target:
        return f"The method returned {count} points and promises exactly {target}."
    return ""


def _changed(before: PointCloud, after: PointCloud) -> bool:
    pairs = [(before.points, after.points), (before.normals, after.normals), (before.faces, after.faces)]
    return any(a is not None and not np.array_equal(a, b) for a, b in pairs if b is not None)


def _count_fault(count: int, n_points: int, target: int, traits: Traits) -> str:
    if count == 0:
        return "The method returned no points."
    if count > n_points:
        return f"The method returned {count} points, more than the {n_points} that it was given."
    if traits.exact_count and not (1 - _FORGIVEN) * target <= count <= target:
        return f"The method returned {count} points and promises exactly {target}."
    return ""


def _value_fault(result: Simplification, before: PointCloud, traits: Traits) -> str:
    bad = int((~np.isfinite(result.points).all(axis=1)).sum())
    if bad:
        return f"{bad} of the {len(result)} points returned are NaN or infinite."
    if result.indices is None:
        return "The method names no rows and promises a subset." if traits.keeps_indices else ""
    indices = np.asarray(result.indices)
    if indices.shape != (len(result),) or indices.dtype.kind != "i":
        wanted = f"({len(result)},) integers"
        return f"The indices are {indices.dtype} of shape {indices.shape}; they must be {wanted}."
    if indices[0] < 0 or indices[-1] >= len(before) or (np.diff(indices) <= 0).any():
        return "The indices are not ascending, distinct rows of the input."
    if not np.array_equal(result.points, before.points[indices]):
        return "The points are not the rows of the input that the indices name."
    return ""
