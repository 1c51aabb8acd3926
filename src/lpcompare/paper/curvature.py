"""Stage 2: curvature of a quadric fitted to each neighbourhood, eqs. 6-11 of Leal et al. (2017).

The neighbours of a point are written in a frame around their direction of least variance ``w``, and
``w = c + p u + q v + r uu/2 + s uv + t vv/2`` is fitted by least squares. H and K are those of that graph at
the point itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.frames import least_variance_directions, tangents
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.threads import Progress, map_in_threads
from lpcompare.types import Indices, Points, Vector

_BLOCK = 2048
_RIDGE = 1e-10

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curvature:
    """Curvature of the surface at each point.

    Attributes
    ----------
    mean : ndarray, shape (n,)
        H = (k1 + k2) / 2, eq. 9, in 1 / model units; its sign is arbitrary, as the normal's is.
    gaussian : ndarray, shape (n,)
        K = k1 k2, eq. 10, in 1 / model units squared.
    """

    mean: Vector
    gaussian: Vector

    @property
    def absolute(self) -> Vector:
        """A = |k1| + |k2|, eq. 11, shape (n,), in 1 / model units."""
        spread = np.sqrt(np.maximum(self.mean**2 - self.gaussian, 0.0))
        return 2.0 * np.maximum(np.abs(self.mean), spread)

    def in_units(self, scale: float) -> Curvature:
        """The curvature of the cloud multiplied by ``scale``."""
        return Curvature(self.mean / scale, self.gaussian / scale**2)


def estimate_curvature(points: Points, n_neighbors: int = 20, progress: Progress | None = None) -> Curvature:
    """Least-squares quadric through the nearest neighbours of every point (eqs. 6-11).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Finite, in any unit.
    n_neighbors : int
        Points per fit, the point itself among them; cut to the size of the cloud.
    progress : callable, optional
        Called with (blocks done, blocks).

    Returns
    -------
    Curvature
        In the units of ``points``. Zero where the neighbours coincide; where they are too few or lie on a
        line, of the fit with the smallest coefficients.
    """
    neighbors = Neighbors(points)
    coordinates = np.ascontiguousarray(points.T)
    order = neighbors.spatial_order
    result = np.empty((2, len(points)))

    def fit(rows: Indices) -> None:
        _, indices = neighbors.query(points[rows], n_neighbors, n_threads=1)
        result[:, rows] = _curvature(coordinates, rows, indices)

    map_in_threads(fit, [order[i : i + _BLOCK] for i in range(0, len(points), _BLOCK)], progress)
    return Curvature(*result)


def _curvature(coordinates: Array, rows: Indices, indices: NDArray[np.intp]) -> Array:
    """H and K at the points ``rows``, shape (2, q)."""
    offsets = coordinates[:, indices.T] - coordinates[:, None, rows]
    size = np.sqrt(np.einsum("ikq,ikq->q", offsets, offsets) / len(offsets[0]))
    size[size == 0] = 1.0
    u, v, w = _to_frame(offsets / size)
    _, p, q, r, s, t = _fit_quadric(u, v, w)
    steep = 1.0 + p * p + q * q
    mean = ((1 + q * q) * r - 2 * p * q * s + (1 + p * p) * t) / (2 * steep * np.sqrt(steep))
    gaussian = (r * t - s * s) / (steep * steep)
    return np.stack([mean / size, gaussian / size**2])


def _to_frame(offsets: Array) -> tuple[Array, Array, Array]:
    """Coordinates (k, q) of the offsets (3, k, q) along two tangents and the normal of their PCA plane."""
    means = offsets.mean(axis=1)
    covariances = np.stack(
        [
            np.einsum("kq,kq->q", offsets[i], offsets[j]) / offsets.shape[1] - means[i] * means[j]
            for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        ]
    )
    normals = least_variance_directions(covariances)
    x, y, z = offsets
    u, v, w = (x * axis[0] + y * axis[1] + z * axis[2] for axis in (*tangents(normals), normals))
    return u, v, w


def _fit_quadric(u: Array, v: Array, w: Array) -> Array:
    """Coefficients c, p, q, r, s, t of the least-squares quadric of each column, shape (6, q)."""
    basis = (np.ones_like(u), u, v, u * u / 2, u * v, v * v / 2)
    gram = np.empty((6, 6, u.shape[1]))
    moments = np.empty((6, u.shape[1]))
    for i, a in enumerate(basis):
        moments[i] = np.einsum("kq,kq->q", a, w)
        for j, b in enumerate(basis[: i + 1]):
            gram[i, j] = gram[j, i] = np.einsum("kq,kq->q", a, b)
    # s counts twice in the norm of a quadratic form, which keeps the ridge independent of the tangents
    gram[range(6), range(6)] += _RIDGE * len(u) * np.array([1.0, 1, 1, 1, 2, 1])[:, None]
    return _solve_positive(gram, moments)


def _solve_positive(matrices: Array, right: Array) -> Array:
    """Solve many small positive definite systems (m, m, q) x (m, q) by Cholesky, all at once."""
    size = len(matrices)
    lower = np.zeros_like(matrices)
    solution = np.empty_like(right)
    for j in range(size):
        lower[j, j] = np.sqrt(matrices[j, j] - np.sum(lower[j, :j] ** 2, axis=0))
        below = matrices[j + 1 :, j] - np.sum(lower[j + 1 :, :j] * lower[j, :j], axis=1)
        lower[j + 1 :, j] = below / lower[j, j]
        solution[j] = (right[j] - np.sum(lower[j, :j] * solution[:j], axis=0)) / lower[j, j]
    for j in reversed(range(size)):
        solution[j] = (solution[j] - np.sum(lower[j + 1 :, j] * solution[j + 1 :], axis=0)) / lower[j, j]
    return solution
