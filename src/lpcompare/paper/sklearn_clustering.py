"""Stage 1 by scikit-learn's GaussianMixture: the reference for `lpcompare.paper.clustering`."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.mixture import GaussianMixture

from lpcompare.paper.clustering import Mixture
from lpcompare.types import Points


def cluster_points_with_sklearn(points: Points, n_clusters: int, rng: np.random.Generator) -> Mixture:
    """Fit scikit-learn's mixture with its defaults; arguments and result as in `cluster_points`."""
    n_clusters = min(n_clusters, len(np.unique(points, axis=0)))
    if len(points) == 1:
        return Mixture(
            np.zeros(1, dtype=np.intp), np.ones(1), points.copy(), 1e-6 * np.eye(3)[None], np.empty(0), True
        )
    model = GaussianMixture(n_clusters, random_state=int(rng.integers(2**31)))
    with warnings.catch_warnings():
        # said by Mixture.converged
        warnings.simplefilter("ignore", ConvergenceWarning)
        labels = model.fit_predict(points)
    names = ("weights", "means", "covariances")
    parameters: dict[str, Any] = {name: getattr(model, f"{name}_") for name in names}
    history = len(points) * np.asarray(getattr(model, "lower_bounds_", [model.lower_bound_]))
    return Mixture(
        labels.astype(np.intp), **parameters, log_likelihoods=history, converged=bool(model.converged_)
    )
