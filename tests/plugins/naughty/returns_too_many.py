"""Returns one point more than it promises."""

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def returns_too_many(points, target_count, *, rng):
    return Simplification(points[: target_count + 1].copy(), np.arange(target_count + 1))
