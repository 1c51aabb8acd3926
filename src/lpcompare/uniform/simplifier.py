"""`lp_uniform` and `lp_placed` from points to points: the estimator `UniformSimplifier`."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from lpcompare.checks import check_choice, check_integer, check_number, check_points, check_seed, check_target
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.geometry.surface import Surface, estimate_surface
from lpcompare.paper.cluster_count import ClusterCountSetting, check_n_clusters
from lpcompare.paper.curvature import Curvature
from lpcompare.paper.estimator import CloudEstimator
from lpcompare.progress import Callback, StageClock
from lpcompare.types import Indices, Points, Simplification
from lpcompare.uniform.clusters import (
    ClusterDensity,
    cluster_densities,
    refine_in_density,
    solve_programs,
    spread_points,
)
from lpcompare.uniform.placement import place_points
from lpcompare.uniform.program import SpreadCertificate, Stop
from lpcompare.uniform.rims import Rims, find_rims
from lpcompare.uniform.swaps import EMPHASES


class UniformSimplifier(CloudEstimator):
    """Thin a cloud without holes: one point per blue-noise cell, chosen by the program of its cluster.

    Parameters
    ----------
    target_reduction, target_count : float, int
        Share removed or points kept; exactly one of the two.
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
        Called with (stage, done, total) as each of "clustering", "curvature", "cells", "swaps" and
        "selection" proceeds.

    Attributes
    ----------
    simplification_ : Simplification
    sample_indices_ : ndarray of int, shape (m,)
        Rows that were kept, ascending; of placed points, the rows that they come from.
    labels_ : ndarray of int, shape (n,)
        Cluster of each point.
    cells_ : ndarray of int, shape (n,)
        Cell of each point: the place in ``sample_indices_`` of the kept point that stands for it.
    mixture_ : Mixture
        Weights, means, covariances in model units, and the log-likelihood per iteration (eqs. 2-5).
    cluster_count_ : ClusterCount or None
        The curve of n_clusters="auto".
    curvature_ : Curvature
        H, K and A of each point (eqs. 9-11), in model units.
    converged_ : bool
        Whether expectation maximization met its tolerance; `ConvergenceWarning` is given where it did not.
    n_iter_ : int
        Iterations of expectation maximization.
    certificates_ : tuple of SpreadCertificate
        Per cluster that owns a kept point: densities (eqs. 12, 15), Z (eq. 14), cost and bound.
    timings_ : dict of str to float
        Seconds per stage.

    References
    ----------
    N. Leal, E. Leal, G. Sanchez-Torres, A Linear Programming Approach for 3D Point Cloud Simplification,
    2017, section V.

    Examples
    --------
    >>> import numpy as np
    >>> cloud = np.random.default_rng(0).normal(size=(400, 3))
    >>> thin, values = UniformSimplifier(target_count=40, n_clusters=3).fit_resample(cloud, cloud[:, 0])
    >>> thin.shape, values.shape
    ((40, 3), (40,))
    """

    def __init__(
        self,
        *,
        target_reduction: float | None = None,
        target_count: int | None = None,
        placed: bool = False,
        n_clusters: ClusterCountSetting = 20,
        n_neighbors: int = 20,
        emphasis: str = "balanced",
        n_rounds: int = 6,
        density_tolerance: float = 0.05,
        gap: float = 5e-3,
        time_limit: float = 10.0,
        random_state: int | np.random.Generator | None = 0,
        callback: Callback | None = None,
    ) -> None:
        self.target_reduction = target_reduction
        self.target_count = target_count
        self.placed = placed
        self.n_clusters = n_clusters
        self.n_neighbors = n_neighbors
        self.emphasis = emphasis
        self.n_rounds = n_rounds
        self.density_tolerance = density_tolerance
        self.gap = gap
        self.time_limit = time_limit
        self.random_state = random_state
        self.callback = callback

    def fit(self, X: Any, y: object = None) -> Self:
        """Cluster, spread the budget over cells, swap points, and solve each cluster's program.

        Parameters
        ----------
        X : array_like, shape (n, 3)
            Finite coordinates in model units; never changed.
        y : object
            Ignored; scikit-learn's habit.

        Returns
        -------
        UniformSimplifier
            Itself, fitted.

        Raises
        ------
        InputError
            The cloud or a setting cannot be worked on.
        SolverError
            The solver ended without a selection.
        """
        points = check_points(X)
        n_keep = check_target(len(points), self.target_reduction, self.target_count)
        self._check_settings()
        rng, clock = check_seed(self.random_state), StageClock(self.callback)
        cloud, center, scale = normalize(points)

        mixture = self._cluster(cloud, rng, clock.stage("clustering"))
        progress = clock.stage("curvature")
        tree = Neighbors(cloud)
        surface = estimate_surface(tree, self.n_neighbors, progress)
        density = cluster_densities(tree.sorted_points, mixture.labels[tree.order])
        rims = find_rims(tree.sorted_points, surface, n_keep)
        kept, cells, certificates = self._select(tree, surface, rims, density, n_keep, clock)

        rows = tree.order[kept].astype(np.intp)
        ascending = np.argsort(rows)
        self.sample_indices_ = rows[ascending]
        self.cells_ = tree.in_rows(np.argsort(ascending)[cells])
        self.labels_, self.mixture_ = mixture.labels, mixture.in_units(center, scale)
        self.curvature_ = Curvature(*tree.in_rows(surface.curvatures).T).in_units(scale)
        self.certificates_ = tuple(c.in_units(1 / scale) for c in certificates)
        self.n_features_in_ = 3
        moved = None
        if self.placed:
            clock.stage("placement")
            moved = place_points(tree, surface, rims, kept[ascending]) * scale + center
        self.timings_ = clock.stop()
        self.simplification_ = self._simplification(points, moved)
        return self

    def _check_settings(self) -> None:
        check_n_clusters(self.n_clusters)
        check_integer("n_neighbors", self.n_neighbors, 1)
        check_choice("emphasis", self.emphasis, EMPHASES)
        check_integer("n_rounds", self.n_rounds, 0)
        check_number("density_tolerance", self.density_tolerance, 0.0)
        check_number("gap", self.gap, 0.0)
        check_number("time_limit", self.time_limit, 0.0)

    def _select(
        self,
        tree: Neighbors,
        surface: Surface,
        rims: Rims,
        density: ClusterDensity,
        n_keep: int,
        clock: StageClock,
    ) -> tuple[Indices, Indices, list[SpreadCertificate]]:
        """Places of the tree that are kept, the cell of each place, and the certificates."""
        clock.stage("cells")
        curvature = Curvature(*surface.curvatures.T).absolute
        sites = spread_points(tree, surface, rims, curvature, density, n_keep)
        clock.stage("swaps")
        sites = refine_in_density(
            tree,
            surface,
            sites,
            density,
            n_rounds=self.n_rounds,
            tolerance=self.density_tolerance,
            emphasis=EMPHASES[self.emphasis],
        )
        return solve_programs(
            tree.sorted_points,
            surface,
            rims,
            density,
            sites,
            tolerance=self.density_tolerance,
            stop=Stop(self.gap, self.time_limit),
            progress=clock.stage("selection"),
        )

    def _simplification(self, points: Points, moved: Points | None) -> Simplification:
        info: dict[str, Any] = {
            "labels": self.labels_,
            "curvature": self.curvature_.absolute,
            "certificates": self.certificates_,
            "n_clusters": len(self.certificates_),
            "n_certified": sum(bool(c.proven) for c in self.certificates_),
            "largest_residual": float(max(c.residual for c in self.certificates_)),
            "converged": self.converged_,
        }
        if self.cluster_count_:
            info["cluster_count"] = self.cluster_count_
        rows = self.sample_indices_
        if moved is None:
            return Simplification(points[rows], rows, self.timings_, info)
        return Simplification(moved, None, self.timings_, info | {"source": rows})
