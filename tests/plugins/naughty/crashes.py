"""Reads from address zero."""

import ctypes

from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def crashes(points, target_count, *, rng):
    ctypes.string_at(0)
