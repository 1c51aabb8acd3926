"""Leaves the interpreter."""

import os

from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def exits(points, target_count, *, rng):
    os._exit(3)
