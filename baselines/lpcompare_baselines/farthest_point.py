"""Farthest point sampling: each point is the one farthest from all before it (numpy, exact).

Eldar, Lindenbaum, Porat and Zeevi; also known as Gonzalez's k-centre greedy. The plain algorithm takes n
times m steps; here the points are looked after in the leaves of a k-d tree, as in Han et al., QuickFPS, IEEE
TCAD 42(11), 2023, and all points that cannot influence each other are taken together. The result is the same.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._buckets import farthest_points
from lpcompare_baselines._orders import first_of

TRAITS = Traits(
    family="spacing",
    wraps="numpy",
    source="Eldar, Lindenbaum, Porat and Zeevi, The farthest point strategy for progressive image sampling, "
    "IEEE Transactions on Image Processing 6(9), 1997",
    licence="BSD-3-Clause",
    progressive=True,
)


def farthest_point(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep the first ``target_count`` points of the farthest-point order.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the first point.

    Returns
    -------
    Simplification
        A subset of the input; ``info["order"]`` has the rank of each kept point, shape (m,).
    """
    rows = farthest_points(points, target_count, int(rng.integers(len(points))))
    return first_of(points, rows, target_count)
