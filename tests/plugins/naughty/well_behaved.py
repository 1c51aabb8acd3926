"""Keeps rows drawn at random."""

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def well_behaved(points, target_count, *, rng):
    indices = np.sort(rng.choice(len(points), target_count, replace=False))
    return Simplification(points[indices], indices, {"draw": 0.0}, {"drawn": target_count})
