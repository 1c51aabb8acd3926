"""Stage 1: expectation maximisation for a mixture of Gaussians, eqs. 1-5 of Leal et al. (2017).

Each iteration is two matrix products per block of points. With the ten features
``f = [1, x, y, z, xx, yy, zz, xy, xz, yz]`` of a point, the log-density of every component is linear in ``f``
(n x 10 times 10 x K), and so are the sums that eqs. 2-4 need (K x n times n x 10).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from lpcompare.geometry.k_means import k_means, nearest_centers
from lpcompare.threads import BLOCK, Progress, for_blocks
from lpcompare.types import Indices, Points, Vector

FIT_LIMIT = 50_000
"""Larger clouds are fitted on a random subsample of this many points and the fit is applied to all."""

_START_LIMIT = 16_000
_TOLERANCE = 1e-3
"""The fit ends when the mean log-likelihood changes by less (scikit-learn's rule)."""
_REGULARIZATION = 1e-6
"""Added to each variance, so that a component cannot collapse onto a point, a line or a plane."""
_NEGLIGIBLE = 37.0
_LOST = 1e-6
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@dataclass(frozen=True, eq=False)
class Mixture:
    """A fitted mixture and the cluster of every point.

    Attributes
    ----------
    labels : ndarray of int, shape (n,)
        The most probable component of each point (eq. 1).
    weights : ndarray, shape (K,)
        Mixing weights w_c, eq. 2.
    means : ndarray, shape (K, 3)
        Eq. 3.
    covariances : ndarray, shape (K, 3, 3)
        Eq. 4.
    log_likelihoods : ndarray, shape (iterations,)
        Eq. 5 before each update, for the points that were fitted.
    converged : bool
        Whether the mean log-likelihood changed by less than the tolerance.
    """

    labels: Indices
    weights: Vector
    means: Points
    covariances: NDArray[np.float64]
    log_likelihoods: Vector
    converged: bool

    @property
    def n_clusters(self) -> int:
        """Number of components K."""
        return len(self.weights)

    def responsibilities(self, points: Points) -> NDArray[np.float64]:
        """Membership probabilities P(c | x_i) of eq. 1 for points (n, 3) in the fit's units: (n, K)."""
        middle = self.means.mean(axis=0)
        near_origin = replace(self, means=self.means - middle)
        logits = _features(points - middle) @ _log_density_coefficients(near_origin)
        densities = np.exp(logits - logits.max(axis=1, keepdims=True))
        return densities / densities.sum(axis=1, keepdims=True)

    def in_units(self, center: Vector, scale: float) -> Mixture:
        """The same mixture for points that were multiplied by ``scale`` and moved by ``center``."""
        return replace(self, means=self.means * scale + center, covariances=self.covariances * scale**2)


def cluster_points(
    points: Points,
    n_clusters: int,
    rng: np.random.Generator,
    *,
    start: Indices | None = None,
    max_iterations: int = 100,
    fit_limit: int = FIT_LIMIT,
    progress: Progress | None = None,
) -> Mixture:
    """Fit a mixture of full-covariance Gaussians (eqs. 1-5) and assign every point to a component.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Normalised cloud (mean zero, mean squared radius one).
    n_clusters : int
        Components K; cut to the number of distinct points.
    rng : numpy.random.Generator
        Draws the subsamples and the k-means++ centres.
    start : ndarray of int, shape (n,), optional
        Hard assignment to start from, in place of k-means.
    max_iterations : int
    fit_limit : int
        Clouds with more points are fitted on a random subsample of this size.
    progress : callable, optional
        Called with (iterations done, max_iterations).

    Returns
    -------
    Mixture
        In the units of ``points``. A component may own no point.
    """
    rows = _fitted_rows(len(points), fit_limit, rng)
    # one thread inside each of ours: faster, and the same sums on any machine
    with threadpool_limits(1):
        labels = start_labels(points[rows], n_clusters, rng) if start is None else start[rows]
        labels = np.unique(labels, return_inverse=True)[1]
        mixture = _expectation_maximization(points[rows], labels, max_iterations, progress)
        return replace(mixture, labels=assign(points, mixture))


def assign(points: Points, mixture: Mixture) -> Indices:
    """The most probable component of each point: ndarray of int, shape (n,)."""
    coefficients, labels = _log_density_coefficients(mixture), np.empty(len(points), dtype=np.intp)
    for_blocks(len(points), lambda block: assign_block(points[block], coefficients, labels[block]))
    return labels


def start_labels(points: Points, n_clusters: int, rng: np.random.Generator) -> Indices:
    """Hard assignment by k-means, its centres fitted on a subsample: ndarray of int, shape (n,)."""
    sample = points[_fitted_rows(len(points), _START_LIMIT, rng)]
    n_distinct = len(np.unique(sample, axis=0))
    seed = int(rng.integers(2**31))
    return nearest_centers(points, k_means(sample, min(n_clusters, n_distinct), seed))


def _fitted_rows(n_points: int, limit: int, rng: np.random.Generator) -> slice | Indices:
    """Sorted rows of a random subsample, or all of them where the cloud is small enough."""
    return slice(None) if n_points <= limit else np.sort(rng.choice(n_points, limit, replace=False))


def _expectation_maximization(
    points: Points, labels: Indices, max_iterations: int, progress: Progress | None
) -> Mixture:
    mixture = _maximize(_hard_sums(_features(points), labels), labels)
    history: list[float] = []
    for iteration in range(1, max_iterations + 1):
        sums, log_likelihood = _expect(points, mixture)
        mixture = _maximize(sums, labels)
        history.append(log_likelihood)
        if progress:
            progress(iteration, max_iterations)
        if len(history) > 1 and abs(history[-1] - history[-2]) < _TOLERANCE * len(points):
            return replace(mixture, log_likelihoods=np.array(history), converged=True)
    return replace(mixture, log_likelihoods=np.array(history))


def _features(points: Points) -> NDArray[np.float64]:
    """Monomials [1, x, y, z, xx, yy, zz, xy, xz, yz] of each point, shape (n, 10)."""
    features = np.empty((len(points), 10))
    features[:, 0] = 1.0
    features[:, 1:4] = points
    for column, (i, j) in enumerate(_PAIRS, 4):
        np.multiply(points[:, i], points[:, j], out=features[:, column])
    return features


def _log_density_coefficients(mixture: Mixture) -> NDArray[np.float64]:
    """Log w_c p(x|c) as coefficients of the monomials, shape (10, K)."""
    # by eigenvectors: an inverse would lose the digits of components that are nearly flat
    variances, axes = np.linalg.eigh(mixture.covariances)
    means, precisions = mixture.means, (axes / variances[:, None]) @ axes.transpose(0, 2, 1)
    linear = np.einsum("cij,cj->ci", precisions, means)
    constant = -0.5 * (
        3 * np.log(2 * np.pi) + np.log(variances).sum(axis=1) + np.einsum("ci,ci->c", means, linear)
    )
    square = -0.5 * precisions[:, range(3), range(3)]
    cross = -precisions[:, (0, 0, 1), (1, 2, 2)]
    rows = np.column_stack([np.log(mixture.weights) + constant, linear, square, cross])
    return np.ascontiguousarray(rows.T, dtype=np.float64)


def _expect(points: Points, mixture: Mixture) -> tuple[NDArray[np.float64], float]:
    """Eqs. 1 and 5: the sums over points of responsibility x monomial, (K, 10), and the log-likelihood."""
    coefficients, n_blocks = _log_density_coefficients(mixture), -(-len(points) // BLOCK)
    sums, totals = np.zeros((n_blocks, *coefficients.T.shape)), np.zeros(n_blocks)

    def expect(block: slice) -> None:
        at = block.start // BLOCK
        totals[at] = expect_block(points[block], coefficients, sums[at])

    for_blocks(len(points), expect)
    return sums.sum(axis=0), float(totals.sum())


@njit(cache=True, nogil=True)
def _log_densities(x, y, z, coefficients, logits):
    """Log w_c p(x|c) of one point for every component; the most probable of them is returned."""
    best = 0
    for c in range(len(logits)):
        linear = coefficients[0, c] + x * coefficients[1, c] + y * coefficients[2, c] + z * coefficients[3, c]
        square = x * x * coefficients[4, c] + y * y * coefficients[5, c] + z * z * coefficients[6, c]
        cross = x * y * coefficients[7, c] + x * z * coefficients[8, c] + y * z * coefficients[9, c]
        logits[c] = linear + square + cross
    for c in range(1, len(logits)):
        if logits[c] > logits[best]:
            best = c
    return best


@njit(cache=True, nogil=True)
def expect_block(points, coefficients, sums):
    """Add responsibility x monomial of a block to ``sums`` (K, 10); its log-likelihood.

    Responsibilities below the rounding of one are left out.
    """
    shares, chosen = np.empty(coefficients.shape[1]), np.empty(coefficients.shape[1], np.int64)
    log_likelihood = 0.0
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        best = _log_densities(x, y, z, coefficients, shares)
        largest, total, n_chosen = shares[best], 0.0, 0
        for c in range(len(shares)):
            if shares[c] > largest - _NEGLIGIBLE:
                shares[c] = np.exp(shares[c] - largest) if c != best else 1.0
                total += shares[c]
                chosen[n_chosen] = c
                n_chosen += 1
        log_likelihood += largest + np.log(total)
        monomials = 1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z
        for c in chosen[:n_chosen]:
            share = shares[c] / total
            for j in range(10):
                sums[c, j] += share * monomials[j]
    return log_likelihood


@njit(cache=True, nogil=True)
def assign_block(points, coefficients, labels):
    """The most probable component of every point of a block, the first among equals."""
    logits = np.empty(coefficients.shape[1])
    for i in range(len(points)):
        labels[i] = _log_densities(points[i, 0], points[i, 1], points[i, 2], coefficients, logits)


def _hard_sums(features: NDArray[np.float64], labels: Indices) -> NDArray[np.float64]:
    """The sums of `_expect` when each point belongs to one component, (K, 10)."""
    n_clusters = int(labels.max()) + 1
    sums = np.empty((n_clusters, 10))
    for j in range(10):
        sums[:, j] = np.bincount(labels, features[:, j])
    return sums


def _maximize(sums: NDArray[np.float64], labels: Indices) -> Mixture:
    """Eqs. 2-4 from the sums of responsibility x monomial."""
    counts = sums[:, 0] + 10 * np.finfo(float).eps
    means = sums[:, 1:4] / counts[:, None]
    covariances = np.empty((len(sums), 3, 3))
    for column, (i, j) in enumerate(_PAIRS, 4):
        moment = sums[:, column] / counts - means[:, i] * means[:, j]
        covariances[:, i, j] = covariances[:, j, i] = moment
    covariances[:, range(3), range(3)] += _REGULARIZATION
    # a component that lost its points waits with the spread of the whole cloud
    lost = counts < _LOST
    means[lost], covariances[lost] = 0.0, np.eye(3)
    return Mixture(labels, counts / counts.sum(), means, covariances, np.empty(0), False)
