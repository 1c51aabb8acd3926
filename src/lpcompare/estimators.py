"""`lp_density`, `lp_printed`, `lp_uniform` and `lp_placed` as estimators of scikit-learn."""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator

from lpcompare.checks import check_points
from lpcompare.paper.simplifier import LPThinning
from lpcompare.paper.thinning import Thinning
from lpcompare.types import Points
from lpcompare.uniform.simplifier import UniformThinning


class CloudEstimator(Thinning, BaseEstimator):
    """An estimator whose `fit` thins a cloud (n, 3)."""

    def fit_resample(self, X: Any, y: Any = None) -> tuple[Points, Any]:
        """Fit, and return the kept points with what belongs to them, as imbalanced-learn does.

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


class LPSimplifier(LPThinning, CloudEstimator):
    """The method of Leal et al. (2017) with everything that it computes on the way.

    Parameters
    ----------
    target_reduction, target_count : float, int
        Share removed or points kept; exactly one of the two.
    method : {"lp_density", "lp_printed"}
        "lp_density" keeps each cluster's mean inverse distance (eq. 14 with k = 1); "lp_printed" is
        eqs. 12-26 as they stand, with k = 1 / PR.
    n_clusters : int or "auto"
        Components of the mixture, cut to the number of distinct points; "auto" takes the number of least BIC.
        Clouds of more than 50,000 points are fitted on a random subsample of 50,000, and the fit is applied
        to all points.
    n_neighbors : int
        Points per curvature fit, the point itself among them.
    retention : {"exact-count", "keep-features"}
        What the target counts: all kept points, or the reduction of the points that are not features.
    feature_share : float
        Largest share of a cluster's budget that features take under "exact-count".
    density : {"mean", "printed"}
        D_c as the text says it, or as eq. 12 prints it (it then depends on the unit of the model).
    solver : str
        "highs" (HiGHS from a starting solution), "highs-cold", or any mixed-integer solver of cvxpy.
    time_limit : float
        Seconds per cluster; at the limit the best selection so far is kept.
    gap : float
        Relative gap per cluster that the solver may leave.
    random_state : int, numpy.random.Generator or None
        Seed of the k-means start, of subsamples and of the starting selections.
    callback : callable, optional
        Called with (stage, done, total) as each of "clustering", "curvature", "selection" proceeds.

    Attributes
    ----------
    simplification_ : Simplification
    sample_indices_ : ndarray of int, shape (m,)
        Rows that were kept, ascending.
    labels_ : ndarray of int, shape (n,)
        Cluster of each point.
    mixture_ : Mixture
        Weights, means, covariances in model units, and the log-likelihood per iteration (eqs. 2-5).
    cluster_count_ : ClusterCount or None
        The curve of n_clusters="auto".
    curvature_ : Curvature
        H, K and A of each point (eqs. 9-11), in model units.
    feature_mask_ : ndarray of bool, shape (n,)
    converged_ : bool
        Whether expectation maximization met its tolerance; `ConvergenceWarning` is given where it did not.
    n_iter_ : int
        Iterations of expectation maximization.
    certificates_ : tuple of Certificate
        Per cluster that owns a point: densities (eqs. 12, 15), Z (eq. 14), bound and proof.
    timings_ : dict of str to float
        Seconds per stage.

    References
    ----------
    E. Leal, N. Leal, G. Sanchez-Torres, A Linear Programming Approach for 3D Point Cloud Simplification,
    2017.

    Examples
    --------
    >>> import numpy as np, lpcompare
    >>> cloud = np.random.default_rng(0).normal(size=(400, 3))
    >>> fitted = lpcompare.LPSimplifier(target_count=40, n_clusters=4).fit(cloud)
    >>> len(fitted.sample_indices_), {c.status for c in fitted.certificates_}
    (40, {'optimal'})
    """


class UniformSimplifier(UniformThinning, CloudEstimator):
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
