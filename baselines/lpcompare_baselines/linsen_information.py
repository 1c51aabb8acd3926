"""The point with the least information content removed, again and again: a reading of Linsen 2001.

L. Linsen, Point Cloud Representation, Technical Report 2001-3, University of Karlsruhe; the 2017 paper's [5]. The
text could not be read. Known of it, from what other papers say: each point has an information content that its
neighborhood decides, and points with the least of it are removed.

Decisions:

- The information content is the sum of three parts without a unit: how far the point lies from the plane of
  its neighbors, how far from their center within that plane (neighbors on one side only: a rim, or a gap), both
  over the mean distance to them; and how much their normals turn, the mean of ``1 - |n . n_j|``.
- Neighbors are the k nearest points that are left; the content is brought up to date after each removal.
  Normals are those of the whole cloud.
- The parts have the same weight.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._elimination import SIGNATURE, eliminate
from lpcompare_baselines._hoods import normals_and_variation
from lpcompare_baselines._plane_kernel import dot, fit_plane

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Linsen, Point cloud representation, Technical Report 2001-3, University of Karlsruhe",
    family="curvature",
    reading=True,
)


def linsen_information(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 12
) -> Simplification:
    """Keep the points with the highest information content.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Points of a neighborhood.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    normals, _ = normals_and_variation(points, nearest_others(points, n_neighbors)[1])
    kept = eliminate(points, target_count, information, n_neighbors, data=normals).kept
    return Simplification(points[kept], kept)


@njit(SIGNATURE, cache=True)
def information(row, hood, points, normals):
    """Offset from the plane and the center of the neighbors, and the turn of their normals."""
    k = len(hood)
    offsets, mean_distance, turn = np.empty((k, 3)), 0.0, 0.0
    for i in range(k):
        for c in range(3):
            offsets[i, c] = points[hood[i], c] - points[row, c]
        mean_distance += np.sqrt(dot(offsets[i], offsets[i])) / k
        turn += (1.0 - abs(dot(normals[row], normals[hood[i]]))) / k
    if mean_distance == 0.0:
        return turn
    center, axes = np.empty(3), np.empty((3, 3))
    fit_plane(offsets, np.ones(k), center, axes)
    above = abs(dot(axes[0], center))
    beside = np.sqrt(max(dot(center, center) - above**2, 0.0))
    return (above + beside) / mean_distance + turn
