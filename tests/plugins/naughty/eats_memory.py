"""Asks for 50 GiB, block by block, and touches all of it."""

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def eats_memory(points, target_count, *, rng):
    blocks = [np.ones((1 << 24,)) for _ in range(400)]
    return Simplification(points[: len(blocks)])
