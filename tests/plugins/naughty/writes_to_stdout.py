"""Writes to standard output in Python and below it."""

import os
import sys

import numpy as np

from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy")


def writes_to_stdout(points, target_count, *, rng):
    sys.stdout.write("noise " * 100_000)
    os.write(1, b"noise below Python " * 100_000)
    return Simplification(points[:target_count].copy(), np.arange(target_count))
