"""What both estimators do alike: keep their settings, cluster, and resample as imbalanced-learn does."""

from __future__ import annotations

import warnings
from typing import Any, Self

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.exceptions import ConvergenceWarning

from lpcompare.checks import check_points
from lpcompare.paper.cluster_count import AUTO, ClusterCountSetting, check_n_clusters, choose_n_clusters
from lpcompare.paper.clustering import Mixture, cluster_points
from lpcompare.threads import Progress
from lpcompare.types import Points, Simplification


class CloudEstimator(BaseEstimator):
    """An estimator whose `fit` thins a cloud (n, 3) and leaves ``simplification_`` and ``sample_indices_``."""

    n_clusters: ClusterCountSetting
    simplification_: Simplification
    sample_indices_: np.ndarray
    mixture_: Mixture

    def fit(self, X: Any, y: object = None) -> Self:
        """Thin the cloud; each estimator says how."""
        raise NotImplementedError

    def fit_resample(self, X: Any, y: Any = None) -> tuple[Points, Any]:
        """Fit, and return the kept points with what belongs to them.

        Parameters
        ----------
        X : array_like, shape (n, 3)
            Finite coordinates in model units.
        y : array_like, shape (n, ...), optional
            Any value of each point.

        Returns
        -------
        X : ndarray, shape (m, 3)
        y : ndarray, shape (m, ...), or None
            The values of the rows ``sample_indices_``.
        """
        points = self.fit(X, y).simplification_.points
        return points, None if y is None else np.asarray(y)[self.sample_indices_]

    def responsibilities(self, X: Any) -> np.ndarray:
        """Membership probabilities P(c | x_i) of eq. 1 under the fitted mixture, shape (n, K)."""
        return self.mixture_.responsibilities(check_points(X))

    def _cluster(self, cloud: Points, rng: np.random.Generator, progress: Progress) -> Mixture:
        """Stage 1 for the normalised cloud; sets ``cluster_count_``, ``converged_`` and ``n_iter_``."""
        wanted = check_n_clusters(self.n_clusters)
        self.cluster_count_ = choose_n_clusters(cloud, rng) if wanted == AUTO else None
        n_clusters = self.cluster_count_.n_clusters if self.cluster_count_ else int(wanted)
        mixture = cluster_points(cloud, n_clusters, rng, progress=progress)
        self.converged_, self.n_iter_ = mixture.converged, len(mixture.log_likelihoods)
        if not mixture.converged:
            warnings.warn(
                f"Expectation maximization did not converge in {self.n_iter_} iterations; its clusters are "
                "used as they are. Another n_clusters or random_state may converge.",
                ConvergenceWarning,
                stacklevel=3,
            )
        return mixture
