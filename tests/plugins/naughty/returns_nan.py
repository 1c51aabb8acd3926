"""Returns a NaN."""

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy", moves_points=True)


def returns_nan(points, target_count, *, rng):
    moved = points[:target_count].copy()
    moved[0, 0] = np.nan
    return Simplification(moved)
