"""The point that stands closest to another for the size of the features there removed: a reading of Dey 2001.

T. K. Dey, J. Giesen and J. Hudson, Decimating samples for mesh simplification, 13th Canadian Conference on
Computational Geometry, 2001, 85-88; the 2017 paper's [3]. The text could not be read. Known of it: points are
deleted where the sample is denser than the local feature size asks for, which is seen from the Voronoi diagram.

Decisions:

- The local feature size at a point is its distance to its second pole. The poles, after Amenta and Bern 1998,
  are the vertex of the point's Voronoi cell that is farthest from it, and the farthest one on the other side;
  they lie near the medial axis, one inside and one outside. Voronoi vertices are the centers of the Delaunay
  tetrahedra's spheres. At the hull, where the cell is not bounded, the first pole lies outwards at infinity.
- The feature size is taken once, from the whole cloud; the diagram is not made again after a removal.
- It is at most the diagonal of the bounding box: planes have none, and at least the distance to the nearest
  point: noise puts poles next to the surface.
- The point with the smallest ratio of distance to the nearest point left over feature size goes first, until
  the count is reached. The largest ratio removed is the sampling density that the result has.
- A cloud without volume has no tetrahedra; all its points have the same feature size.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.types import Indices, Points, Simplification, Traits, Vector
from lpcompare_baselines._elimination import SIGNATURE, eliminate

TRAITS = Traits(
    wraps="scipy.spatial.Delaunay, lpcompare (numba)",
    source="Dey, Giesen and Hudson, Decimating samples for mesh simplification, "
    "13th Canadian Conference on Computational Geometry, 2001",
    family="spacing",
    reading=True,
)


def dey_decimation(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Thin until distances to the nearest point are as large as the features allow.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.

    Returns
    -------
    Simplification
        A subset of the input; ``info["largest_ratio"]`` is the largest ratio of distance over feature size
        at which a point was removed.
    """
    result = eliminate(points, target_count, _ratio, 1, data=feature_sizes(points)[:, None])
    largest = float(result.values.max(initial=0.0))
    return Simplification(points[result.kept], result.kept, info={"largest_ratio": largest})


@njit(SIGNATURE, cache=True)
def _ratio(row, hood, points, sizes):
    """Distance to the nearest point over the feature size."""
    squared = 0.0
    for c in range(3):
        squared += (points[hood[0], c] - points[row, c]) ** 2
    return np.sqrt(squared) / sizes[row, 0]


def feature_sizes(points: Points) -> Vector:
    """Distance of each point to its second pole, shape (n,), in model units."""
    widest = bounding_box_diagonal(points) or 1.0
    nearest = nearest_others(points, 1)[0].max(axis=1, initial=0.0)
    try:
        delaunay = Delaunay(points - points.mean(axis=0))
    except (QhullError, ValueError):
        return np.full(len(points), widest)
    sizes = np.linalg.norm(_second_poles(delaunay), axis=1)
    duplicates, _, twins = delaunay.coplanar.T
    sizes[duplicates] = sizes[twins]
    return np.clip(np.where(sizes > 0, sizes, widest), np.minimum(nearest, widest), widest)


def _second_poles(delaunay: Delaunay) -> Points:
    """Offset of each point's second pole, shape (n, 3); zero where there is none."""
    n, corners = len(delaunay.points), delaunay.simplices.astype(np.intp)
    away = _centers(delaunay.points[corners])[:, None] - delaunay.points[corners]
    finite = np.isfinite(away).all(axis=(1, 2))
    rows, away = corners[finite].ravel(), away[finite].reshape(-1, 3)
    first = _farthest(rows, away, n)
    outwards = _hull_directions(delaunay)
    on_hull = outwards.any(axis=1)
    first[on_hull] = outwards[on_hull]
    behind = np.einsum("ti,ti->t", away, first[rows]) < 0
    return _farthest(rows[behind], away[behind], n)


def _centers(corners: NDArray[np.float64]) -> Points:
    """Centers of the spheres through four corners (t, 4, 3) each; not finite where they are coplanar."""
    a, b, c = (corners[:, i] - corners[:, 0] for i in (1, 2, 3))
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    volume = np.einsum("ti,ti->t", a, bc)
    squares = (np.einsum("ti,ti->t", v, v)[:, None] for v in (a, b, c))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        offsets = sum(square * cross for square, cross in zip(squares, (bc, ca, ab), strict=True))
        return corners[:, 0] + offsets / (2.0 * volume[:, None])


def _farthest(rows: Indices, offsets: Points, n: int) -> Points:
    """The longest offset of each row, shape (n, 3); zero for rows without any."""
    squared = np.einsum("ti,ti->t", offsets, offsets)
    largest = np.zeros(n)
    np.maximum.at(largest, rows, squared)
    longest = squared == largest[rows]
    found = np.zeros((n, 3))
    found[rows[longest]] = offsets[longest]
    return found


def _hull_directions(delaunay: Delaunay) -> Points:
    """Sum of the outward normals of the hull's facets at each point, shape (n, 3); zero inside."""
    corners = delaunay.points[delaunay.convex_hull]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # the cloud is centered, so that the hull holds the origin
    normals *= np.sign(np.einsum("fi,fi->f", normals, corners[:, 0]))[:, None]
    directions = np.zeros_like(delaunay.points)
    for column in delaunay.convex_hull.T:
        np.add.at(directions, column, normals)
    return directions
