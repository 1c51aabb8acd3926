"""Sharp edges kept, then the point that its neighbors describe best removed: a reading of Song and Feng 2009.

H. Song and H.-Y. Feng, A progressive point cloud simplification algorithm with preserved sharp edge data,
International Journal of Advanced Manufacturing Technology 45, 2009, 583-592; the 2017 paper's [18]. The text
could not be read. Known of it: the points on sharp edges are found and kept, each other point has an importance
for the local surface, and the least important one is removed until the user's share is reached. (What the 2017
paper says of [18] fits the authors' global clustering of 2008; ``docs/related-work.md`` says more.)

Decisions:

- Edge rule: the normals of the neighborhood are parted into two groups, by two-means on directions without a
  sign. A point lies on a sharp edge when the mean directions differ by more than ``edge_angle``, each group has
  three members or more, and the point lies within half its spacing of the planes of both groups.
- Edge points may take ``edge_share`` of the result. Where there are more, those that lie farthest apart are
  kept and the others count as ordinary points.
- The importance of a point is its distance to the plane fitted to its nearest points that are left, itself
  left out, brought up to date after each removal.
- In flat places that distance is 0. See ``even`` of ``_elimination.eliminate`` for the rule that keeps them
  even and not empty.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Mask, Points, Simplification, Traits
from lpcompare_baselines._elimination import SIGNATURE, eliminate
from lpcompare_baselines._hoods import normals_and_variation, thinned
from lpcompare_baselines._plane_kernel import dot, fit_plane

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Song and Feng, A progressive point cloud simplification algorithm with preserved sharp edge data, "
    "International Journal of Advanced Manufacturing Technology 45, 2009",
    family="curvature",
    reading=True,
)

_BLOCK = 16384
_MEANS_STEPS = 3
_FEWEST_OF_A_GROUP = 3
_SPACING_NEIGHBORS = 6


def song_feng(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 16,
    edge_angle: float = 30.0,
    edge_share: float = 0.5,
) -> Simplification:
    """Keep the points of sharp edges and the most important of the others.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Points of a neighborhood.
    edge_angle : float, optional
        Least angle between the two groups of normals at a sharp edge, in degrees.
    edge_share : float, optional
        Largest share of the result that edge points take, from 0 to 1.

    Returns
    -------
    Simplification
        A subset of the input; ``info["n_edges"]`` is the number of edge points found.
    """
    edges = sharp_edges(points, n_neighbors, edge_angle)
    fixed = np.zeros(len(points), bool)
    fixed[thinned(points, np.flatnonzero(edges), int(edge_share * target_count))] = True
    result = eliminate(points, target_count, left_out_distance, n_neighbors, fixed=fixed, even=True)
    return Simplification(points[result.kept], result.kept, info={"n_edges": int(edges.sum())})


@njit(SIGNATURE, cache=True)
def left_out_distance(row, hood, points, _data):
    """Distance of a point to the plane through its neighbors, in model units."""
    offsets = np.empty((len(hood), 3))
    for i in range(len(hood)):
        for c in range(3):
            offsets[i, c] = points[hood[i], c] - points[row, c]
    center, axes = np.empty(3), np.empty((3, 3))
    fit_plane(offsets, np.ones(len(hood)), center, axes)
    return abs(dot(axes[0], center))


def sharp_edges(points: Points, n_neighbors: int, edge_angle: float) -> Mask:
    """Points where two groups of normals meet, shape (n,)."""
    distances, neighbors = nearest_others(points, n_neighbors)
    normals, _ = normals_and_variation(points, neighbors)
    spacing = distances[:, :_SPACING_NEIGHBORS].mean(axis=1) if neighbors.size else np.zeros(len(points))
    edges = np.zeros(len(points), bool)
    for start in range(0, len(points), _BLOCK):
        rows = np.arange(start, min(start + _BLOCK, len(points)))
        hoods = np.column_stack([rows, neighbors[rows]])
        offsets = points[hoods] - points[rows][:, None]
        directions, members = _two_groups(normals[hoods])
        parted = np.abs(np.einsum("qi,qi->q", *directions)) < np.cos(np.radians(edge_angle))
        for direction, member in zip(directions, members, strict=True):
            heights = np.einsum("qki,qi->qk", offsets, direction) * member
            n_members = member.sum(axis=1)
            on_plane = np.abs(heights.sum(axis=1)) <= 0.5 * spacing[rows] * np.maximum(n_members, 1)
            parted &= on_plane & (n_members >= _FEWEST_OF_A_GROUP)
        edges[rows] = parted
    return edges


def _two_groups(normals: NDArray[np.float64]) -> tuple[list[Points], list[Mask]]:
    """Two-means of the normals (q, k, 3) of each neighborhood: mean directions (q, 3) and members (q, k)."""
    cosines = np.abs(np.einsum("qki,qli->qkl", normals, normals, optimize=True))
    farthest = cosines.reshape(len(normals), -1).argmin(axis=1)
    every = np.arange(len(normals))
    directions = [normals[every, seed] for seed in np.divmod(farthest, normals.shape[1])]
    members = [np.ones(normals.shape[:2], bool)] * 2
    for _ in range(_MEANS_STEPS):
        along = [np.einsum("qki,qi->qk", normals, direction) for direction in directions]
        first = np.abs(along[0]) >= np.abs(along[1])
        members = [first, ~first]
        directions = [
            _unit(np.einsum("qki,qk->qi", normals, np.sign(a) * member), direction)
            for a, member, direction in zip(along, members, directions, strict=True)
        ]
    return directions, members


def _unit(vectors: Points, otherwise: Points) -> Points:
    """Vectors at length one, or the others where they have no length."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1.0), otherwise)
