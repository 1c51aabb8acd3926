"""Iterative simplification that keeps points: each pair is contracted onto one of its ends.

`lpcompare_baselines.pauly_iterative` with the place restricted to the two points of the pair: the cost is the
lesser value of Q_p + Q_q at p and at q. A later contraction can then cost less than one before it.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines.pauly_iterative import contract_pairs

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="surface",
)


def pauly_iterative_subset(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 8
) -> Simplification:
    """Contract pairs of points onto the end where their quadric error is less.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    n_neighbors : int, optional
        k, the pairs that each point makes at first.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    indices = np.flatnonzero(contract_pairs(points, target_count, n_neighbors, subset=True).alive)
    return Simplification(points[indices], indices)
