"""`lp_uniform` and `lp_placed` from points to points: the paper's stages with the second objective."""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.geometry.scale import normalize
from lpcompare.lp.checks import check_cloud, check_integer, check_number, check_target
from lpcompare.lp.clock import Callback, StageClock
from lpcompare.lp.clustering import cluster_points
from lpcompare.lp.curvature import estimate_curvature
from lpcompare.lp.placement import place_points
from lpcompare.lp.quadrics import estimate_surface
from lpcompare.lp.uniform import Stop
from lpcompare.lp.uniform_reduction import (
    cluster_densities,
    refine_in_density,
    solve_programmes,
    spread_points,
)
from lpcompare.types import Simplification


def simplify_uniformly(
    points: Any,
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    placed: bool = False,
    n_clusters: int = 20,
    n_neighbors: int = 20,
    n_rounds: int = 12,
    density_tolerance: float = 0.01,
    gap: float = 5e-3,
    time_limit: float = 10.0,
    random_state: int | np.random.Generator | None = 0,
    callback: Callback | None = None,
) -> Simplification:
    """Thin a point cloud without holes: one point per blue-noise cell, chosen by the clusters' programmes.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Finite coordinates in model units; never changed.
    target_reduction, target_count : float, int
        Share removed or points kept; exactly one of the two.
    placed : bool
        Move each kept point to the minimum of its tangent-plane quadric.
    n_clusters : int
        Components of the mixture (eqs. 1-5); cut to the number of distinct points.
    n_neighbors : int
        Points per curvature fit (eqs. 6-11), the point itself among them.
    n_rounds : int
        Rounds of exchange against eq. 27 before the programmes.
    density_tolerance : float
        Largest Z of eq. 14, as a share of the cluster's density, that costs nothing.
    gap : float
        Relative gap per cluster that the solver may leave.
    time_limit : float
        Seconds per cluster; at the limit the best selection so far is kept.
    random_state : int, numpy.random.Generator or None
        Seed of the k-means start and of subsamples.
    callback : callable, optional
        Called with (stage, done, total) as "clustering", "curvature" and "selection" proceed.

    Returns
    -------
    Simplification
        ``info`` holds the certificates, the cluster of every input point and, for placed points, the row of
        the input that each comes from (``source``).

    Raises
    ------
    InputError
        The cloud or a setting cannot be worked on.
    SolverError
        The solver ended without a selection.
    """
    points = check_cloud(points)
    n_keep = check_target(len(points), target_reduction, target_count)
    n_clusters = check_integer("n_clusters", n_clusters, 1)
    n_neighbors = check_integer("n_neighbors", n_neighbors, 1)
    n_rounds = check_integer("n_rounds", n_rounds, 0)
    density_tolerance = check_number("density_tolerance", density_tolerance, 0.0)
    stop = Stop(check_number("gap", gap, 0.0), check_number("time_limit", time_limit, 0.0))
    cloud, center, scale = normalize(points)
    clock = StageClock(callback)

    progress = clock.stage("clustering")
    labels = cluster_points(cloud, n_clusters, np.random.default_rng(random_state), progress=progress).labels
    curvature = estimate_curvature(cloud, n_neighbors, clock.stage("curvature")).absolute
    clock.stage("cells")
    surface, density = estimate_surface(cloud), cluster_densities(cloud, labels)
    indices = spread_points(cloud, surface, curvature, density, n_keep)
    clock.stage("refinement")
    indices = refine_in_density(cloud, indices, density, n_rounds, density_tolerance)
    progress = clock.stage("selection")
    indices, certificates = solve_programmes(
        cloud,
        surface,
        density,
        indices,
        tolerance=density_tolerance,
        stop=stop,
        progress=progress,
    )
    info: dict[str, Any] = {
        "labels": labels,
        "certificates": tuple(c.in_units(1 / scale) for c in certificates),
        "n_clusters": len(certificates),
        "n_certified": sum(c.proven for c in certificates),
        "largest_residual": max(c.residual for c in certificates),
    }
    if not placed:
        return Simplification(points[indices], indices, clock.stop(), info)
    clock.stage("placement")
    moved = place_points(cloud, surface, indices) * scale + center
    return Simplification(moved, None, clock.stop(), info | {"source": indices})
