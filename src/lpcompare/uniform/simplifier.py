"""`lp_uniform` and `lp_placed` from points to points: the paper's stages with the second objective."""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.checks import check_choice, check_integer, check_number, check_points, check_target
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.geometry.surface import estimate_surface
from lpcompare.paper.cluster_count import AUTO, ClusterCountSetting, check_n_clusters, choose_n_clusters
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import Curvature
from lpcompare.progress import Callback, StageClock
from lpcompare.types import Indices, Points, Simplification
from lpcompare.uniform.clusters import (
    cluster_densities,
    refine_in_density,
    solve_programmes,
    spread_points,
)
from lpcompare.uniform.placement import place_points
from lpcompare.uniform.program import Stop
from lpcompare.uniform.rims import find_rims
from lpcompare.uniform.swaps import EMPHASES


def simplify_uniformly(
    points: Any,
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    **settings: Any,
) -> Simplification:
    """Thin a point cloud without holes: one point per blue-noise cell, chosen by the clusters' programmes.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Finite coordinates in model units; never changed.
    target_reduction, target_count : float, int
        Share removed or points kept; exactly one of the two.
    **settings
        Those of `UniformReducer`.

    Returns
    -------
    Simplification
        As `UniformReducer.reduce` gives it.

    Raises
    ------
    InputError
        The cloud or a setting cannot be worked on.
    SolverError
        The solver ended without a selection.
    """
    cloud = check_points(points)
    n_keep = check_target(len(cloud), target_reduction, target_count)
    return UniformReducer(cloud, **settings).reduce(n_keep)


class UniformReducer:
    """A clustered cloud with its curvature and tangent planes, ready to be thinned to any count.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Clean cloud, in model units.
    placed : bool
        Move each kept point to the minimum of its tangent-plane quadric.
    n_clusters : int or "auto"
        Components of the mixture (eqs. 1-5), cut to the number of distinct points; "auto" takes the number
        of least BIC on a subsample.
    n_neighbors : int
        Points per curvature fit (eqs. 6-11), the point itself among them.
    emphasis : str
        What is given up last: "balanced", "error" (eq. 27 alone) or "coverage" (no original far from a kept
        point). See `EMPHASES`.
    n_rounds : int
        Rounds of swaps before the programs.
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
    """

    def __init__(
        self,
        points: Points,
        *,
        placed: bool = False,
        n_clusters: ClusterCountSetting = 20,
        n_neighbors: int = 20,
        emphasis: str = "balanced",
        n_rounds: int = 6,
        density_tolerance: float = 0.01,
        gap: float = 5e-3,
        time_limit: float = 10.0,
        random_state: int | np.random.Generator | None = 0,
        callback: Callback | None = None,
    ) -> None:
        wanted = check_n_clusters(n_clusters)
        n_neighbors = check_integer("n_neighbors", n_neighbors, 1)
        self._emphasis = EMPHASES[check_choice("emphasis", emphasis, EMPHASES)]
        self._n_rounds = check_integer("n_rounds", n_rounds, 0)
        self._tolerance = check_number("density_tolerance", density_tolerance, 0.0)
        self._stop = Stop(check_number("gap", gap, 0.0), check_number("time_limit", time_limit, 0.0))
        self._points, self._placed, self._callback = points, placed, callback
        self._cloud, self._center, self._scale = normalize(points)
        self._tree = Neighbors(self._cloud)
        self._cloud = self._tree.sorted_points
        rng, clock = np.random.default_rng(random_state), StageClock(callback)
        progress = clock.stage("clustering")
        self._count = choose_n_clusters(self._tree.points, rng) if wanted == AUTO else None
        n_clusters = self._count.n_clusters if self._count else int(wanted)
        labels = cluster_points(self._tree.points, n_clusters, rng, progress=progress).labels[
            self._tree.order
        ]
        self._surface = estimate_surface(self._tree, n_neighbors, clock.stage("curvature"))
        self._curvature = Curvature(*self._surface.curvatures.T).absolute
        self._density = cluster_densities(self._cloud, labels)
        self._timings = clock.stop()

    def reduce(self, n_keep: int) -> Simplification:
        """Keep ``n_keep`` points.

        Parameters
        ----------
        n_keep : int
            From 1 to n.

        Returns
        -------
        Simplification
            ``info`` holds the certificates, the cluster of every input point, the curve of "auto"
            (``cluster_count``) and, for placed points, the row that each comes from (``source``).
        """
        clock = StageClock(self._callback)
        clock.stage("cells")
        rims = find_rims(self._cloud, self._surface, n_keep)
        sites = spread_points(self._tree, self._surface, rims, self._curvature, self._density, n_keep)
        clock.stage("refinement")
        sites = refine_in_density(
            self._tree,
            self._surface,
            sites,
            self._density,
            n_rounds=self._n_rounds,
            tolerance=self._tolerance,
            emphasis=self._emphasis,
        )
        indices, certificates = solve_programmes(
            self._cloud,
            self._surface,
            rims,
            self._density,
            sites,
            tolerance=self._tolerance,
            stop=self._stop,
            progress=clock.stage("selection"),
        )
        info: dict[str, Any] = {
            "labels": self._in_input_order(self._density.labels),
            "certificates": tuple(c.in_units(1 / self._scale) for c in certificates),
            "n_clusters": len(certificates),
            "n_certified": sum(bool(c.proven) for c in certificates),
            "largest_residual": float(max(c.residual for c in certificates)),
        }
        if self._count:
            info["cluster_count"] = self._count
        if not self._placed:
            rows = np.sort(self._tree.order[indices].astype(np.intp))
            return Simplification(self._points[rows], rows, self._timings | clock.stop(), info)
        clock.stage("placement")
        indices = indices[np.argsort(self._tree.order[indices])]
        moved = place_points(self._tree, self._surface, rims, indices) * self._scale + self._center
        info["source"] = self._tree.order[indices].astype(np.intp)
        return Simplification(moved, None, self._timings | clock.stop(), info)

    def _in_input_order(self, values: Indices) -> Indices:
        result = np.empty_like(values)
        result[self._tree.order] = values
        return result
