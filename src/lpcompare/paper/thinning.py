"""What both of our methods do alike: cluster a cloud, and say where the fit did not converge."""

from __future__ import annotations

import warnings
from typing import Any, Self

import numpy as np

from lpcompare.paper.cluster_count import AUTO, ClusterCountSetting, check_n_clusters, choose_n_clusters
from lpcompare.paper.clustering import Mixture, cluster_points
from lpcompare.threads import Progress
from lpcompare.types import Points, Simplification


class Thinning:
    """A thinning with settings as attributes, whose `fit` leaves ``simplification_`` and ``sample_indices_``.

    It does without scikit-learn, whose import takes longer than all else that a first call does;
    `lpcompare.estimators` makes an estimator of it.
    """

    n_clusters: ClusterCountSetting
    simplification_: Simplification
    sample_indices_: np.ndarray
    mixture_: Mixture

    def fit(self, X: Any, y: object = None) -> Self:
        """Thin the cloud; each method says how."""
        raise NotImplementedError

    def _cluster(self, cloud: Points, rng: np.random.Generator, progress: Progress) -> Mixture:
        """Stage 1 for the normalised cloud; sets ``cluster_count_``, ``converged_`` and ``n_iter_``."""
        wanted = check_n_clusters(self.n_clusters)
        self.cluster_count_ = choose_n_clusters(cloud, rng) if wanted == AUTO else None
        n_clusters = self.cluster_count_.n_clusters if self.cluster_count_ else int(wanted)
        mixture = cluster_points(cloud, n_clusters, rng, progress=progress)
        self.converged_, self.n_iter_ = mixture.converged, len(mixture.log_likelihoods)
        if not mixture.converged:
            from sklearn.exceptions import ConvergenceWarning

            warnings.warn(
                f"Expectation maximization did not converge in {self.n_iter_} iterations; its clusters are "
                "used as they are. Another n_clusters or random_state may converge.",
                ConvergenceWarning,
                stacklevel=3,
            )
        return mixture
