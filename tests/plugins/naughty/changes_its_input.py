"""Moves the points that it was given."""

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def changes_its_input(points, target_count, *, rng):
    points[0] += 1.0
    return Simplification(points[:target_count].copy(), np.arange(target_count))
