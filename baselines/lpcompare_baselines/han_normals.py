"""Edge points kept, the others removed by their distance to the tangent planes around them: a reading of Han 2015.

H. Han, X. Han, F. Sun and C. Huang, Point cloud simplification with preserved edge based on normal vector,
Optik 126(19), 2015, 2157-2162. Only the abstract could be read: edge points are found and kept; of the
others, the least important goes until the user's share is reached; importance is the mean distance of a point
to the estimated tangent planes of its neighbors, in this file ``I(p) = 1/k sum_j |n_j . (p - p_j)|``.

Decisions where the abstract is silent:

- Neighbors come from a k-d tree, not from an octree. They are the k nearest points that are left; normals
  are estimated once, on the whole cloud.
- An edge point lies on the rim of an open surface (a gap of more than 90 degrees between the directions to
  its neighbors in the tangent plane), or on a sharp edge (surface variation above ``edge_variation``, or a
  neighbor whose normal differs by more than ``edge_angle``).
- Edge points may take ``edge_share`` of the result. Where there are more, those that lie farthest apart are
  kept and the others count as ordinary points: scans have more edge points than a small result has room for.
- Importance is brought up to date after each removal.
- All points of a plane have importance 0 and would go before any other point. See ``even`` of
  ``_elimination.eliminate`` for the rule that keeps flat places even and not empty.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Mask, Points, Simplification, Traits
from lpcompare_baselines._elimination import SIGNATURE, eliminate
from lpcompare_baselines._hoods import IndexArray, normals_and_variation, on_rim, thinned

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Han, Han, Sun and Huang, Point cloud simplification with preserved edge based on normal vector, "
    "Optik 126(19), 2015 (abstract)",
    family="curvature",
    reading=True,
)


def han_normals(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 16,
    edge_variation: float = 0.05,
    edge_angle: float = 30.0,
    edge_share: float = 0.5,
) -> Simplification:
    """Keep the edge points and the most important of the others.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Points of a neighborhood.
    edge_variation : float, optional
        Surface variation above which a point lies on a sharp edge, from 0 to 1/3.
    edge_angle : float, optional
        Angle between normals above which a point lies on a sharp edge, in degrees.
    edge_share : float, optional
        Largest share of the result that edge points take, from 0 to 1.

    Returns
    -------
    Simplification
        A subset of the input; ``info["n_edges"]`` is the number of edge points found.
    """
    _, neighbors = nearest_others(points, n_neighbors)
    normals, variation = normals_and_variation(points, neighbors)
    edges = _edges(points, neighbors, normals, variation > edge_variation, edge_angle)
    fixed = np.zeros(len(points), bool)
    fixed[thinned(points, np.flatnonzero(edges), int(edge_share * target_count))] = True

    result = eliminate(
        points, target_count, tangent_distance, n_neighbors, data=normals, fixed=fixed, even=True
    )
    return Simplification(points[result.kept], result.kept, info={"n_edges": int(edges.sum())})


@njit(SIGNATURE, cache=True)
def tangent_distance(row, hood, points, normals):
    """Mean distance of a point to the tangent planes at its neighbors, in model units."""
    total = 0.0
    for other in hood:
        height = 0.0
        for c in range(3):
            height += normals[other, c] * (points[row, c] - points[other, c])
        total += abs(height)
    return total / len(hood)


def _edges(points: Points, neighbors: IndexArray, normals: Points, rough: Mask, edge_angle: float) -> Mask:
    """Points on a rim or on a sharp edge."""
    cosines = np.abs(np.einsum("nki,ni->nk", normals[neighbors], normals))
    sharp = (cosines < np.cos(np.radians(edge_angle))).any(axis=1)
    return rough | sharp | on_rim(points, neighbors, normals)
