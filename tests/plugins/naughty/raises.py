"""Raises an error."""

from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def raises(points, target_count, *, rng):
    raise ValueError("no luck today")
