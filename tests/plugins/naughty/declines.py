"""Declines every input."""

from lpcompare.errors import NotApplicable
from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def declines(points, target_count, *, rng):
    raise NotApplicable("This method works on Tuesdays only.")
