"""The method of Leal et al. (2017) from points to points."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from lpcompare.checks import (
    check_choice,
    check_integer,
    check_number,
    check_points,
    check_seed,
    check_solver,
    check_target,
)
from lpcompare.geometry.scale import normalize
from lpcompare.paper.cluster_count import ClusterCountSetting, check_n_clusters
from lpcompare.paper.curvature import estimate_curvature
from lpcompare.paper.features import feature_mask
from lpcompare.paper.program import SolverSettings
from lpcompare.paper.reduction import Reading, plan_clusters, reduce_clusters
from lpcompare.paper.thinning import Thinning
from lpcompare.progress import Callback, StageClock
from lpcompare.types import Points, Simplification

METHODS = ("lp_density", "lp_printed")


class LPThinning(Thinning):
    """The method of `LPSimplifier`, whose settings and attributes these are."""

    def __init__(
        self,
        *,
        target_reduction: float | None = None,
        target_count: int | None = None,
        method: str = "lp_density",
        n_clusters: ClusterCountSetting = 20,
        n_neighbors: int = 20,
        retention: str = "exact-count",
        feature_share: float = 0.4,
        density: str = "mean",
        solver: str = "highs",
        time_limit: float = 10.0,
        gap: float = 0.0,
        random_state: int | np.random.Generator | None = 0,
        callback: Callback | None = None,
    ) -> None:
        self.target_reduction = target_reduction
        self.target_count = target_count
        self.method = method
        self.n_clusters = n_clusters
        self.n_neighbors = n_neighbors
        self.retention = retention
        self.feature_share = feature_share
        self.density = density
        self.solver = solver
        self.time_limit = time_limit
        self.gap = gap
        self.random_state = random_state
        self.callback = callback

    def fit(self, X: Any, y: object = None) -> Self:
        """Cluster, mark the features, and solve each cluster's program.

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
            The cloud, the target or a setting cannot be worked on.
        SolverError
            The solver ended without a selection.
        """
        points = check_points(X)
        target_count = check_target(len(points), self.target_reduction, self.target_count)
        self._check_settings()
        rng = check_seed(self.random_state)
        cloud, center, scale = normalize(points)
        clock = StageClock(self.callback)

        mixture = self._cluster(cloud, rng, clock.stage("clustering"))
        curvature = estimate_curvature(cloud, self.n_neighbors, clock.stage("curvature"))
        features = feature_mask(curvature.absolute, mixture.labels)
        progress = clock.stage("selection")
        tasks = plan_clusters(
            cloud,
            mixture.labels,
            features,
            curvature.absolute,
            target_count=target_count,
            rng=rng,
            retention=self.retention,
            feature_share=self.feature_share,
        )
        indices, certificates = reduce_clusters(
            cloud,
            tasks,
            Reading(self.method, self.density, scale),
            SolverSettings(check_solver(self.solver), self.time_limit, self.gap),
            progress,
        )

        self.timings_ = clock.stop()
        self.labels_, self.mixture_ = mixture.labels, mixture.in_units(center, scale)
        self.curvature_, self.feature_mask_ = curvature.in_units(scale), features
        self.sample_indices_, self.certificates_ = indices, tuple(certificates)
        self.n_features_in_ = 3
        self.simplification_ = self._simplification(points)
        return self

    def _check_settings(self) -> None:
        check_choice("method", self.method, METHODS)
        check_n_clusters(self.n_clusters)
        check_integer("n_neighbors", self.n_neighbors, 1)
        check_choice("retention", self.retention, ("exact-count", "keep-features"))
        check_number("feature_share", self.feature_share, 0.0, 1.0)
        check_choice("density", self.density, ("mean", "printed"))
        check_number("time_limit", self.time_limit, 0.0)
        check_number("gap", self.gap, 0.0)
        check_solver(self.solver)

    def _simplification(self, points: Points) -> Simplification:
        info = {
            "labels": self.labels_,
            "curvature": self.curvature_.absolute,
            "feature_mask": self.feature_mask_,
            "certificates": self.certificates_,
            "n_clusters": self.mixture_.n_clusters,
            "n_features_kept": int(self.feature_mask_[self.sample_indices_].sum()),
            "n_certified": sum(c.proven for c in self.certificates_),
            "largest_residual": max(c.residual for c in self.certificates_),
        }
        return Simplification(points[self.sample_indices_], self.sample_indices_, self.timings_, info)
