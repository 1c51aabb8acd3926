"""Boolean program per cluster that keeps the cluster's density (Leal et al., density-preserving reading).

Leal, Leal and Sanchez-Torres (2017). Gaussian mixture clusters (eqs. 1-5), feature points by curvature
(eqs. 6-11), and in each cluster the selection whose mean inverse distance to the centroid is that of the
cluster: eqs. 12-26 with both densities averaged and k = 1, the reading under which the text's "maintains
the proportion of the density" can be met.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.paper.simplifier import LPThinning
from lpcompare.progress import Callback
from lpcompare.types import Points, Simplification, Traits

TRAITS = Traits(
    family="ours",
    wraps="lpcompare (cvxpy, HiGHS)",
    source="Leal and others, A Linear Programming Approach for 3D Point Cloud Simplification, 2017",
    in_tiles=True,
)
THINNING = LPThinning


def lp_density(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    callback: Callback | None = None,
    **settings: Any,
) -> Simplification:
    """Keep ``target_count`` of the points; the settings are those of `LPSimplifier`.

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
    thinning = THINNING(
        target_count=target_count, method="lp_density", random_state=rng, callback=callback, **settings
    )
    return thinning.fit(points).simplification_
