"""Boolean program per cluster that keeps the density and one point per blue-noise cell.

Leal, Leal and Sanchez-Torres (2017), section V, made concrete: cells as many as the budget, smaller where the
surface bends, corrected by swaps against the error; in each cluster the program of eqs. 14-26 chooses one
point of every cell so that the density is kept and the originals are represented best.
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
    in_tiles=True,
)
THINNING = UniformThinning


def lp_uniform(
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
        A subset of the input.
    """
    thinning = THINNING(target_count=target_count, random_state=rng, callback=callback, **settings)
    return thinning.fit(points).simplification_
