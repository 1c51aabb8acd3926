"""Takes as long as it is told, then keeps the first rows."""

import time

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def sleeps(points, target_count, *, rng, seconds: float = 0.05):
    time.sleep(seconds)
    return Simplification(points[:target_count].copy(), np.arange(target_count))
