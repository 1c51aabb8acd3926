"""Random choice weighted by curvature: rough places keep more points (numpy).

The weight of a point is the surface variation of its neighbourhood, the share of its variance that lies along
the normal, after Pauly, Gross and Kobbelt; a floor keeps flat places from being emptied.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes
from lpcompare.types import Points, Simplification, Traits, Vector

TRAITS = Traits(
    family="curvature",
    wraps="numpy, scipy.spatial.KDTree",
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    licence="BSD-3-Clause",
)

_BLOCK = 65536


def curvature_sample(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 16,
    floor: float = 0.5,
) -> Simplification:
    """Keep ``target_count`` rows, drawn without replacement in proportion to their weights.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
    n_neighbors : int, optional
        Points of a neighbourhood.
    floor : float, optional
        Weight of a flat place, as a share of the mean variation.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    variation = _surface_variation(points, n_neighbors)
    weights = variation + (floor * variation.mean() or 1.0)
    # Efraimidis and Spirakis 2006: the smallest exponential waiting times are such a draw
    waiting = rng.exponential(size=len(points)) / weights
    indices = np.sort(np.argsort(waiting, kind="stable")[:target_count])
    return Simplification(points[indices], indices)


def _surface_variation(points: Points, n_neighbors: int) -> Vector:
    """Share of each neighbourhood's variance that lies along its normal, shape (n,), from 0 to 1/3."""
    _, neighbors = Neighbors(points).query(points, n_neighbors)
    variation = np.zeros(len(points))
    for start in range(0, len(points), _BLOCK):
        block = slice(start, start + _BLOCK)
        hoods = points[neighbors[block]]
        centroids, normals = fit_planes(points, neighbors[block])
        offsets = hoods - centroids[:, None, :]
        along = np.square(np.einsum("qki,qi->qk", offsets, normals)).sum(axis=1)
        total = np.square(offsets).sum(axis=(1, 2))
        np.divide(along, total, out=variation[block], where=total > 0)
    return variation
