"""`lp_uniform` and `lp_placed` from points to points: the paper's stages with the second objective."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator

from lpcompare.checks import check_choice, check_integer, check_number, check_points, check_seed, check_target
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.geometry.surface import Surface, estimate_surface
from lpcompare.paper.cluster_count import AUTO, ClusterCountSetting, check_n_clusters, choose_n_clusters
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import Curvature
from lpcompare.progress import Callback, StageClock
from lpcompare.types import Indices, Points, Simplification, Vector
from lpcompare.uniform.clusters import (
    ClusterDensity,
    SpreadCertificate,
    cluster_densities,
    refine_in_density,
    solve_programmes,
    spread_points,
)
from lpcompare.uniform.placement import place_points
from lpcompare.uniform.program import Stop
from lpcompare.uniform.rims import Rims, find_rims
from lpcompare.uniform.swaps import EMPHASES


class UniformSimplifier(BaseEstimator):
    """`lp_uniform` and `lp_placed` with everything that they compute on the way.

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
        Called with (stage, done, total) as "clustering", "curvature" and "selection" proceed.

    Attributes
    ----------
    simplification_ : Simplification
    sample_indices_ : ndarray of int, shape (m,)
        Rows that were kept, ascending; of placed points the rows that they come from.
    labels_ : ndarray of int, shape (n,)
        Cluster of each point.
    curvature_ : ndarray, shape (n,)
        Absolute curvature of each point (eqs. 9-11), in 1 / model units.
    certificates_ : tuple of Certificate
        Per cluster: densities, Z (eq. 14), bound and proof.
    cluster_count_ : ClusterCount or None
        The curve of n_clusters="auto".
    converged_ : bool
        Whether the mixture's fit ended by its tolerance.
    n_iter_ : int
        Iterations of the mixture's fit.
    timings_ : dict of str to float
        Seconds per stage.

    References
    ----------
    N. Leal, E. Leal, G. Sanchez-Torres, A Linear Programming Approach for 3D Point Cloud Simplification,
    2017, section V.

    Examples
    --------
    >>> import numpy as np, lpcompare
    >>> cloud = np.random.default_rng(0).normal(size=(400, 3))
    >>> simplifier = lpcompare.UniformSimplifier(target_count=40, n_clusters=4).fit(cloud)
    >>> len(simplifier.sample_indices_), len(simplifier.certificates_)
    (40, 4)
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
        density_tolerance: float = 0.01,
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

    def fit(self, X: Any, y: object = None) -> UniformSimplifier:
        """Cluster, spread cells, swap, and solve each cluster's program.

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
        tree = Neighbors(cloud)
        density = self._cluster(tree, rng, clock)
        surface = estimate_surface(tree, self.n_neighbors, clock.stage("curvature"))
        curvature = Curvature(*surface.curvatures.T).absolute
        rims, indices, certificates = self._select(tree, surface, curvature, density, n_keep, clock)
        indices = indices[np.argsort(tree.order[indices])]
        self.sample_indices_ = tree.order[indices].astype(np.intp)
        self.labels_ = _in_input_order(tree, density.labels)
        self.curvature_ = _in_input_order(tree, curvature) / scale
        self.certificates_ = tuple(c.in_units(1 / scale) for c in certificates)
        self.n_features_in_ = 3
        kept = points[self.sample_indices_]
        if self.placed:
            clock.stage("placement")
            kept = place_points(tree, surface, rims, indices) * scale + center
        self.timings_ = clock.stop()
        self.simplification_ = self._simplification(kept)
        return self

    def fit_resample(self, X: Any, y: Any = None) -> tuple[Points, Any]:
        """Fit; return the kept points, shape (m, 3), and their part of ``y`` (None without it)."""
        kept = self.fit(X).simplification_.points
        return kept, None if y is None else np.asarray(y)[self.sample_indices_]

    def _check_settings(self) -> None:
        check_n_clusters(self.n_clusters)
        check_integer("n_neighbors", self.n_neighbors, 1)
        check_choice("emphasis", self.emphasis, EMPHASES)
        check_integer("n_rounds", self.n_rounds, 0)
        for name in ("density_tolerance", "gap", "time_limit"):
            check_number(name, getattr(self, name), 0.0)

    def _cluster(self, tree: Neighbors, rng: np.random.Generator, clock: StageClock) -> ClusterDensity:
        """The clusters and their densities, in the order of the tree."""
        progress, wanted = clock.stage("clustering"), check_n_clusters(self.n_clusters)
        self.cluster_count_ = choose_n_clusters(tree.points, rng) if wanted == AUTO else None
        n_clusters = self.cluster_count_.n_clusters if self.cluster_count_ else int(wanted)
        mixture = cluster_points(tree.points, n_clusters, rng, progress=progress)
        self.converged_, self.n_iter_ = mixture.converged, len(mixture.log_likelihoods)
        return cluster_densities(tree.sorted_points, mixture.labels[tree.order])

    def _select(
        self,
        tree: Neighbors,
        surface: Surface,
        curvature: Vector,
        density: ClusterDensity,
        n_keep: int,
        clock: StageClock,
    ) -> tuple[Rims, Indices, list[SpreadCertificate]]:
        """Rims, kept rows in the order of the tree, and the certificates of the clusters."""
        clock.stage("cells")
        cloud = tree.sorted_points
        rims = find_rims(cloud, surface, n_keep)
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
        indices, certificates = solve_programmes(
            cloud,
            surface,
            rims,
            density,
            sites,
            tolerance=self.density_tolerance,
            stop=Stop(self.gap, self.time_limit),
            progress=clock.stage("selection"),
        )
        return rims, indices, certificates

    def _simplification(self, kept: Points) -> Simplification:
        info: dict[str, Any] = {
            "labels": self.labels_,
            "curvature": self.curvature_,
            "certificates": self.certificates_,
            "n_clusters": len(self.certificates_),
            "n_certified": sum(bool(c.proven) for c in self.certificates_),
            "largest_residual": float(max(c.residual for c in self.certificates_)),
            "converged": self.converged_,
        }
        if self.cluster_count_:
            info["cluster_count"] = self.cluster_count_
        if self.placed:
            return Simplification(kept, None, self.timings_, info | {"source": self.sample_indices_})
        return Simplification(kept, self.sample_indices_, self.timings_, info)


def _in_input_order(tree: Neighbors, values: NDArray[Any]) -> NDArray[Any]:
    result = np.empty_like(values)
    result[tree.order] = values
    return result
