"""Ends its process as a failed C++ assertion does."""

import os
import sys

from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def aborts(points, target_count, *, rng):
    sys.stderr.write("assertion failed: n > 0\n")
    sys.stderr.flush()
    os.abort()
