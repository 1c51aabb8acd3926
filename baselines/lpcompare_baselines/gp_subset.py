"""The points of which a Gaussian process on the surface knows least, added until the count is reached.

Pathak, Baldwin-McDonald, Sels and Penne, GP-PCS: One-shot feature-preserving point cloud simplification with
Gaussian processes on Riemannian manifolds, 2023: a reading of the abstract and of notes on the public code.

1. A value y on each point: its surface variation over 25 neighbors.
2. A Gaussian process on the surface has a Matern kernel K = Phi s(l) Phi^T with the 20 smoothest eigenvectors
   Phi of the graph Laplacian, their eigenvalues l, and s(l) in proportion to (2 nu / w^2 + l)^-(nu + d/2).
3. The width w, the variance and the noise have the largest likelihood on 200 random points.
4. The set starts with farthest points, a third of the count.
5. In rounds, the points of the largest sqrt(variance) + |mean - y| given the values of the set are added.

Decisions: the Laplacian is the normalized one of the graph of 15 neighbors, where the authors' code takes that
of a triangulation. It is that of 4,000 farthest points, and each other point takes the mean of the nearest
three of them: for all 134,345 points of igea, the factors of the matrix took more than 1 GiB and 180 s.
nu = 1.5 and d = 2. K has rank 20, so mean and variance are those of a linear model in 20 unknowns, for the
whole cloud at once, where the authors' code draws some ten thousand points first. y has mean 0 and variance 1.
Each round adds a fifth of the set, as the authors' code does in effect. Equal scores are taken by row. With 20
eigenvectors the variance is soon near 0: what is left is the distance of y from a smooth function, so features
are crowded.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import minimize
from scipy.sparse import csr_array, diags_array, eye_array

from lpcompare.geometry.graphs import gaussian_graph, nearest_others
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Indices, Points, Simplification, Traits, Vector
from lpcompare_baselines._buckets import farthest_points
from lpcompare_baselines._hoods import normals_and_variation

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Pathak, Baldwin-McDonald, Sels and Penne, GP-PCS: One-shot feature-preserving point cloud "
    "simplification with Gaussian processes on Riemannian manifolds, ICPR 2024 (abstract)",
    licence="GPL-3.0-or-later",
    family="curvature",
    reading=True,
)

_EIGENVECTORS, _FITTED, _DENSE = 20, 200, 200
_LANDMARKS, _NEAREST = 4000, 3
_SMOOTHNESS, _DIMENSION = 1.5, 2
_FIRST, _GROWTH = 3, 5
"""The first set is this part of the count; each round adds this part of the set."""


def gp_subset(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 25
) -> Simplification:
    """Keep the points that tell the process most.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the points of step 3 and the first point of step 4.
    n_neighbors : int, optional
        Points that a surface variation is taken over.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    n = len(points)
    values = normals_and_variation(points, nearest_others(points, n_neighbors)[1])[1]
    values = (values - values.mean()) / (values.std() or 1.0)
    some = rng.choice(n, min(n, _FITTED), replace=False)
    n_first = -(-target_count // _FIRST)
    farthest = farthest_points(points, min(n, max(n_first, _LANDMARKS)), int(rng.integers(n)))
    landmarks, kept = farthest[:_LANDMARKS], farthest[:n_first]
    eigenvalues, vectors = smooth_vectors(gaussian_graph(points[landmarks], 15))
    features, noise = fit_process(eigenvalues, spread(points, landmarks, vectors), values, some)
    while len(kept) < target_count:
        mean, variance = posterior(features, noise, kept, values[kept])
        score = np.sqrt(variance) + np.abs(mean - values)
        score[kept] = -np.inf
        n_more = min(target_count - len(kept), -(-len(kept) // _GROWTH))
        kept = np.concatenate([kept, np.argsort(-score, kind="stable")[:n_more]])
    indices = np.sort(kept)
    return Simplification(points[indices], indices)


def smooth_vectors(graph: csr_array) -> tuple[Vector, Points]:
    """The 20 smallest eigenvalues of the normalized Laplacian, shape (k,), and their vectors, shape (n, k).

    Parameters
    ----------
    graph : csr_array, shape (n, n)
        Symmetric weights.
    """
    n = len(graph.indptr) - 1
    roots = diags_array(1 / np.sqrt(np.maximum(graph.sum(axis=1), np.finfo(float).tiny)))
    laplacian = eye_array(n) - roots @ graph @ roots
    if n <= _DENSE:
        found = eigh(laplacian.toarray(), subset_by_index=[0, min(n, _EIGENVECTORS) - 1])
        return np.maximum(found[0], 0), found[1] * np.sqrt(n)
    from scipy.sparse.linalg import eigsh

    # slightly below 0, the shifted matrix has an inverse
    found = eigsh(laplacian.tocsc(), _EIGENVECTORS, sigma=-1e-4, v0=np.ones(n))
    return np.maximum(found[0], 0), found[1] * np.sqrt(n)


def spread(points: Points, landmarks: Indices, vectors: Points) -> Points:
    """Values of the landmarks, shape (l, k), on every point: means of the nearest three, by inverse distance."""
    k = min(_NEAREST, len(landmarks))
    distances, near = Neighbors(points[landmarks]).query(points, k)
    weights = 1 / np.maximum(distances, 1e-9 * (distances.max() or 1.0))
    return np.einsum("ij,ijk->ik", weights / weights.sum(axis=1, keepdims=True), vectors[near])


def fit_process(eigenvalues: Vector, vectors: Points, values: Vector, rows: Indices) -> tuple[Points, float]:
    """Features B with K = B B^T, shape (n, k), and the noise's variance, of the largest likelihood on rows."""
    scale = eigenvalues.max() or 1.0

    def weights(width: float, size: float) -> Vector:
        power = (2 * _SMOOTHNESS * np.exp(-2 * width) + eigenvalues / scale) ** -(
            _SMOOTHNESS + _DIMENSION / 2
        )
        return np.sqrt(np.exp(size) * power / power.sum())

    def cost(at: Vector) -> float:
        return -likelihood(vectors[rows] * weights(at[0], at[1]), values[rows], float(np.exp(at[2])))

    best = minimize(cost, np.array([0.0, 0.0, -2.0]), method="L-BFGS-B", bounds=[(-3, 6), (-10, 5), (-12, 3)])
    return vectors * weights(best.x[0], best.x[1]), float(np.exp(best.x[2]))


def likelihood(features: Points, values: Vector, noise: float) -> float:
    """Logarithm of the density of values under N(0, B B^T + noise I), without its constant."""
    m, k = features.shape
    inner = np.eye(k) + features.T @ features / noise
    seen = features.T @ values / noise
    fit = values @ values / noise - seen @ np.linalg.solve(inner, seen)
    return -0.5 * float(fit + m * np.log(noise) + np.linalg.slogdet(inner)[1])


def posterior(features: Points, noise: float, rows: Indices, values: Vector) -> tuple[Vector, Vector]:
    """Mean and variance of the process on every point, given its values on some rows; shapes (n,)."""
    known = features[rows]
    inner = np.linalg.inv(np.eye(features.shape[1]) + known.T @ known / noise)
    mean = features @ (inner @ (known.T @ values / noise))
    return mean, np.maximum(np.einsum("ij,jk,ik->i", features, inner, features, optimize=True), 0)
