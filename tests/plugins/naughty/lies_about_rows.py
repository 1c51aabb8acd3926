"""Names rows that its points are not."""

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def lies_about_rows(points, target_count, *, rng):
    return Simplification(points[:target_count].copy(), np.arange(target_count) + 1)
