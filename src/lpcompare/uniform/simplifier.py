"""`lp_uniform` and `lp_placed` from points to points."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from lpcompare.checks import check_choice, check_integer, check_number, check_points, check_seed, check_target
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.geometry.surface import Surface
from lpcompare.paper.cluster_count import ClusterCountSetting, check_n_clusters
from lpcompare.paper.curvature import Curvature
from lpcompare.paper.thinning import Thinning
from lpcompare.progress import Callback, StageClock
from lpcompare.types import Indices, Points, Simplification
from lpcompare.uniform.clusters import (
    ClusterDensity,
    cluster_densities,
    refine_in_density,
    solve_programs,
    spread_points,
)
from lpcompare.uniform.program import SpreadCertificate, Stop
from lpcompare.uniform.quadrics import place_points
from lpcompare.uniform.rims import Rims, surface_and_rims
from lpcompare.uniform.swaps import EMPHASES


class UniformThinning(Thinning):
    """The method of `UniformSimplifier`, whose settings and attributes these are."""

    def __init__(
        self,
        *,
        target_reduction: float | None = None,
        target_count: int | None = None,
        placed: bool = False,
        n_clusters: ClusterCountSetting = 20,
        n_neighbors: int = 20,
        emphasis: str = "balanced",
        n_rounds: int = 8,
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
        self
            Fitted.

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
        surface, rims = surface_and_rims(tree, n_keep, self.n_neighbors, progress)
        density = cluster_densities(tree.sorted_points, mixture.labels[tree.order])
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
