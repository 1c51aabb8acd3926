"""Farthest point sampling by fpsample's buckets (QuickFPS), in single precision.

The points are the leaves of a k-d tree of 2^h points each, and a leaf is looked at only when a new point can
come nearer to one of its points than those before. The order is that of the plain algorithm, up to rounding,
from a first point that is drawn: version 1.0.2 counts the start index in the order of the tree, not of the
input.
"""

from __future__ import annotations

import fpsample  # pyright: ignore[reportMissingImports]
import numpy as np

from lpcompare.errors import NotApplicable
from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._guards import check_distinct
from lpcompare_baselines._orders import first_of

TRAITS = Traits(
    wraps="fpsample.bucket_fps_kdline_sampling",
    source="Han and others, QuickFPS: Architecture and algorithm co-design for farthest point sampling in "
    "large-scale point clouds, IEEE TCAD 42(11), 2023",
    licence="MIT",
    family="spacing",
    progressive=True,
    requires=("fpsample",),
    extra="fpsample",
)

_LARGEST_HEIGHT = 7
_FEWEST = 4


def fpsample_farthest_point(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep the first ``target_count`` points of the farthest-point order.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws the first point.

    Returns
    -------
    Simplification
        A subset of the input; ``info["order"]`` has the rank of each kept point, shape (m,).

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for: fpsample would take some of them twice.
    """
    if len(points) < _FEWEST:
        raise NotApplicable(f"fpsample takes {_FEWEST} points or more, and the cloud has {len(points)}.")
    centred = about_center(points).astype(np.float32)
    check_distinct(centred.astype(np.float64), target_count)
    height = min(_LARGEST_HEIGHT, max(1, int(np.log2(len(points)) / 2)))
    first = int(rng.integers(len(points)))
    rows = fpsample.bucket_fps_kdline_sampling(centred, target_count, height, first).astype(np.intp)
    return first_of(points, rows, target_count)
