"""Uniform random choice of rows, without replacement (numpy)."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits

TRAITS = Traits(
    family="random",
    wraps="numpy.random.Generator.choice",
    source="Vitter, Random sampling with a reservoir, ACM TOMS 11(1), 1985",
    licence="BSD-3-Clause",
    in_tiles=True,
)


def random_sample(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep ``target_count`` rows, every subset equally likely.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator

    Returns
    -------
    Simplification
        A subset of the input.
    """
    indices = np.sort(rng.choice(len(points), target_count, replace=False))
    return Simplification(points[indices], indices)
