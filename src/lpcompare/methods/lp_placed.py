"""lp_uniform, each kept point moved to the minimum of its tangent-plane quadric.

The selection of `lp_uniform` (Leal, Leal and Sanchez-Torres, 2017, section V). The quadric of a point sums
the squared distances to the tangent planes of the originals around it (Garland and Heckbert, 1997) and needs
no mesh. ``info["source"]`` has the row of the input that each point comes from.
"""

from __future__ import annotations

import numpy as np

from lpcompare.paper.cluster_count import ClusterCountSetting
from lpcompare.types import Points, Simplification, Traits
from lpcompare.uniform.simplifier import simplify_uniformly

TRAITS = Traits(
    family="ours",
    wraps="lpcompare (cvxpy, HiGHS)",
    source="Leal and others, A Linear Programming Approach for 3D Point Cloud Simplification, 2017",
    moves_points=True,
)


def lp_placed(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_clusters: ClusterCountSetting = 20,
    n_neighbors: int = 20,
    emphasis: str = "balanced",
    n_rounds: int = 6,
    density_tolerance: float = 0.01,
    gap: float = 5e-3,
    time_limit: float = 10.0,
) -> Simplification:
    """Keep ``target_count`` of the points; the settings are those of `UniformReducer`.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator

    Returns
    -------
    Simplification
        New points; ``info["source"]`` has the row that each comes from.
    """
    return simplify_uniformly(
        points,
        target_count=target_count,
        placed=True,
        n_clusters=n_clusters,
        n_neighbors=n_neighbors,
        emphasis=emphasis,
        n_rounds=n_rounds,
        density_tolerance=density_tolerance,
        gap=gap,
        time_limit=time_limit,
        random_state=rng,
    )
