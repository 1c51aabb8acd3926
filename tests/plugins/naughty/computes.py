"""Multiplies small matrices for a while, longer when COMPUTE_ROUNDS says so, then keeps the first rows."""

import os

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def computes(points, target_count, *, rng):
    matrix = np.ones((40, 40))
    for _ in range(int(os.environ.get("COMPUTE_ROUNDS", "2000"))):
        matrix = np.sqrt(matrix @ matrix) + 1.0
    return Simplification(points[:target_count].copy(), np.arange(target_count))
