"""lp_uniform, each kept point moved to the minimum of its tangent-plane quadric.

The selection of `lp_uniform` (Leal, Leal and Sanchez-Torres, 2017, section V). The quadric of a point sums
the squared distances to the tangent planes of the originals around it (Garland and Heckbert, 1997) and needs
no mesh. ``info["source"]`` has the row of the input that each point comes from.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.progress import Callback
from lpcompare.types import Points, Simplification, Traits
from lpcompare.uniform.simplifier import UniformThinning

TRAITS = Traits(
    family="ours",
    wraps="lpcompare (cvxpy, HiGHS)",
    source="Leal and others, A Linear Programming Approach for 3D Point Cloud Simplification, 2017",
    moves_points=True,
)
THINNING = UniformThinning


def lp_placed(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    callback: Callback | None = None,
    **settings: Any,
) -> Simplification:
    """Keep ``target_count`` of the points; the settings are those of `UniformSimplifier`.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
    callback : callable, optional
        Called with (stage, done, total).

    Returns
    -------
    Simplification
        New points; ``info["source"]`` has the row that each comes from.
    """
    thinning = THINNING(
        target_count=target_count, placed=True, random_state=rng, callback=callback, **settings
    )
    return thinning.fit(points).simplification_
