"""Planes found by region growing, thinned by quadtrees inside, kept along their rims: a reading of Whelan 2015.

T. Whelan, L. Ma, E. Bondarev, P. H. N. de With and J. McDonald, Incremental and batch planar simplification
of dense point cloud maps, Robotics and Autonomous Systems 69, 2015, 3-14 (the 2017 paper's [20]); the
quadtree comes from Ma and others, Planar simplification and texturing of dense point cloud maps, ECMR 2013.
The texts could not be read. The segmentation is known from a contribution to OpenCV whose comments number
the algorithms; the rest from what others say. The authors triangulate the planes and leave all other points
to a surface reconstruction; here is the batch case, as a method that keeps a given number of points:

1. segments: the point of least surface variation that is in none begins one; a neighbor joins when its normal is
   within ``angle`` of the segment's, and is grown from in its turn when its variation is below ``max_variation``;
2. a segment joins a larger one beside it when their normals are within the same angle;
3. a segment is planar when it has ``min_size`` points that lie near their common plane;
4. rims of planar segments are kept; their inside keeps one point per leaf of a quadtree, whose leaves are larger where
   no rim point is near; other points are thinned by distance.

Decisions:

- A neighbor is compared with the mean normal of the segment, not with that of the point it is reached from, as the
  code does: that lets a segment creep round a cylinder.
- Two segments lie beside each other when a point of one is among the neighbors of a point of the other.
- Near their plane: the root of the mean squared distance is below the mean spacing of the segment, or below twice
  the same figure of its points' own small neighborhoods, so that noise does not matter.
- A rim point sees a gap of more than 90 degrees between its neighbors of the same segment.
- Shares of the result: rims as many as there are, up to half; of the rest, a point outside planes counts four times as
  much as one inside. Rims and points outside planes that are too many keep those farthest apart.
- Leaves grow up to four times the smallest side, which the count decides. A leaf keeps the point nearest its center.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.geometry.frames import tangents
from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Indices, Mask, Points, Simplification, Traits, Vector
from lpcompare_baselines._calibration import search_size
from lpcompare_baselines._hoods import IndexArray, normals_and_variation, on_rim, thinned

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Whelan, Ma, Bondarev, de With and McDonald, Incremental and batch planar simplification of dense "
    "point cloud maps, Robotics and Autonomous Systems 69, 2015",
    family="surface",
    reading=True,
)

_SPACING_NEIGHBORS = 6
_RIM_SHARE = 0.5
_OUTSIDE_WEIGHT = 4.0
_LEVELS = 3
_CELL_BITS = 21
"""Of the number of a cell along one axis."""
_COUNT_TOLERANCE = 0.02


def whelan_planes(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 16,
    angle: float = 10.0,
    max_variation: float = 0.05,
    min_size: int = 100,
) -> Simplification:
    """Keep rims of planes, few points inside them, and a share of the others.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Points of a neighborhood.
    angle : float, optional
        Largest angle between the normals of a segment and of a point that joins it, in degrees.
    max_variation : float, optional
        Surface variation from which a point's neighbors are not looked at, from 0 to 1/3.
    min_size : int, optional
        Points of the smallest planar segment.

    Returns
    -------
    Simplification
        A subset of the input; ``info`` has the number of planes and of points inside them, on rims and outside.
    """
    distances, neighbors = nearest_others(points, n_neighbors)
    normals, variation = normals_and_variation(points, neighbors)
    segment = segments(neighbors, normals, variation, angle, max_variation)
    spacing = distances[:, :_SPACING_NEIGHBORS].sum(axis=1) / _SPACING_NEIGHBORS
    own_rms = np.sqrt(variation * np.square(distances).mean(axis=1)) if neighbors.size else spacing
    planar, place = _planes(points, segment, spacing, own_rms, min_size)
    on_plane = planar[segment]
    rim = on_plane & on_rim(points, neighbors, normals, segment[neighbors] == segment[:, None])
    inside, outside = on_plane & ~rim, ~on_plane
    n_rim, n_outside, n_inside = _shares(target_count, *(int(m.sum()) for m in (rim, outside, inside)))
    indices = np.concatenate(
        [
            thinned(points, np.flatnonzero(rim), n_rim),
            thinned(points, np.flatnonzero(outside), n_outside),
            _leaf_points((np.cumsum(planar) - 1)[segment], place, inside, rim, n_inside),
        ]
    )
    indices.sort()
    info = {"n_planes": int(planar.sum()), "n_rim": int(rim.sum()), "n_inside": int(inside.sum())}
    return Simplification(points[indices], indices, info=info)


def segments(
    neighbors: IndexArray, normals: Points, variation: Vector, angle: float, max_variation: float
) -> Indices:
    """Number of the segment of each point, shape (n,), those merged that lie side by side with like normals."""
    cosine = np.cos(np.radians(angle))
    segment, sums = _grow(
        neighbors, np.argsort(variation, kind="stable"), normals, variation, cosine, max_variation
    )
    means = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    sizes = np.bincount(segment)
    pairs = np.column_stack([np.repeat(segment, neighbors.shape[1]), segment[neighbors].ravel()])
    pairs = np.unique(pairs[sizes[pairs[:, 0]] < sizes[pairs[:, 1]]], axis=0)
    alike = np.abs(np.einsum("pi,pi->p", means[pairs[:, 0]], means[pairs[:, 1]])) > cosine
    pairs = pairs[alike]
    pairs = pairs[np.argsort(-sizes[pairs[:, 1]], kind="stable")]
    into, is_host = np.arange(len(sizes)), np.zeros(len(sizes), bool)
    for small, large in pairs.tolist():
        if into[small] == small and into[large] == large and not is_host[small]:
            into[small], is_host[large] = large, True
    return np.unique(into[segment], return_inverse=True)[1]


@njit("Tuple((i8[::1], f8[:,::1]))(i8[:,::1], i8[::1], f8[:,::1], f8[::1], f8, f8)", cache=True)
def _grow(neighbors, seeds, normals, variation, cosine, max_variation):
    """Segment of each point, and the sum of the normals of each segment, as if they pointed the same way."""
    segment, queue = np.full(len(seeds), -1), np.empty(len(seeds), np.int64)
    sums = np.zeros((len(seeds), 3))
    n_segments = 0
    for seed in seeds:
        if segment[seed] >= 0:
            continue
        segment[seed], sums[n_segments] = n_segments, normals[seed]
        queue[0], first, last = seed, 0, 1
        while first < last:
            row = queue[first]
            first += 1
            for other in neighbors[row]:
                if segment[other] >= 0:
                    continue
                mean, normal = sums[n_segments], normals[other]
                along = mean[0] * normal[0] + mean[1] * normal[1] + mean[2] * normal[2]
                length = np.sqrt(mean[0] ** 2 + mean[1] ** 2 + mean[2] ** 2)
                if abs(along) <= cosine * length:
                    continue
                segment[other] = n_segments
                for c in range(3):
                    mean[c] += normal[c] if along > 0 else -normal[c]
                if variation[other] < max_variation:
                    queue[last] = other
                    last += 1
        n_segments += 1
    return segment, sums[:n_segments].copy()


def _planes(
    points: Points, segment: Indices, spacing: Vector, own_rms: Vector, min_size: int
) -> tuple[Mask, Points]:
    """Whether each segment is planar, shape (s,), and the place of each point in its segment's plane, (n, 2)."""
    sizes = np.bincount(segment)
    mean = lambda values: np.bincount(segment, values) / sizes  # noqa: E731 - a shorthand for this function only
    offsets = points - points.mean(axis=0)
    offsets -= np.column_stack([mean(column) for column in offsets.T])[segment]
    covariances = np.empty((len(sizes), 3, 3))
    for r in range(3):
        for c in range(3):
            covariances[:, r, c] = mean(offsets[:, r] * offsets[:, c])
    values, vectors = np.linalg.eigh(covariances)
    rms = np.sqrt(np.maximum(values[:, 0], 0.0))
    near = rms <= np.maximum(mean(spacing), 2.0 * mean(own_rms))
    axes = tangents(vectors[:, :, 0].T)
    place = np.column_stack([np.einsum("ni,in->n", offsets, axis[:, segment]) for axis in axes])
    return (sizes >= min_size) & near, place


def _shares(target_count: int, n_rim: int, n_outside: int, n_inside: int) -> tuple[int, int, int]:
    """Points of the result from rims, from outside planes and from inside; none above what there are."""
    rim = min(n_rim, int(_RIM_SHARE * target_count))
    rest = target_count - rim
    weight = _OUTSIDE_WEIGHT * n_outside
    outside = min(n_outside, round(rest * weight / (weight + n_inside)) if weight + n_inside else 0)
    inside = min(n_inside, rest - outside)
    outside = min(n_outside, rest - inside)
    return target_count - inside - outside, outside, inside


def _leaf_points(plane: Indices, place: Points, inside: Mask, rim: Mask, n_wanted: int) -> Indices:
    """The wanted number of points inside planes: the first of each leaf, the fullest leaves first."""
    rows, edge = np.flatnonzero(inside), np.flatnonzero(rim)
    if n_wanted == 0:
        return rows[:0]
    low = place.min(axis=0)
    finest = float(np.ptp(place, axis=0).max()) / 2 ** (_CELL_BITS - 1) or 1.0

    def leaves(side: float) -> tuple[Indices, Vector]:
        return _leaves(plane, (place - low) / max(side, finest), rows, edge)

    side = search_size(
        lambda side: len(np.unique(leaves(side)[0])),
        n_wanted,
        finest * 2 ** (_CELL_BITS - 1) / np.sqrt(n_wanted),
        tolerance=int(_COUNT_TOLERANCE * n_wanted),
        max_calls=16,
    )
    leaf, off_center = leaves(side)
    _, leaf, n_in = np.unique(leaf, return_inverse=True, return_counts=True)
    order = np.lexsort((rows, off_center, leaf))
    rank = np.empty(len(rows), np.intp)
    rank[order] = np.arange(len(rows)) - np.repeat(np.cumsum(n_in) - n_in, n_in)
    return rows[np.lexsort((rows, -n_in[leaf], rank))[:n_wanted]]


def _leaves(plane: Indices, place: Points, rows: Indices, edge: Indices) -> tuple[Indices, Vector]:
    """Leaf of each of the given rows, and its distance from the leaf's center in sides of the leaf.

    ``place`` is in units of the smallest side. A leaf is the largest cell that holds no rim point.
    """
    cells = place.astype(np.int64)

    def key(which: Indices, level: int) -> Indices:
        u, v = (cells[which] >> level).T
        return (plane[which] << 2 * _CELL_BITS) | (u << _CELL_BITS) | v

    level = np.zeros(len(rows), np.intp)
    free = np.arange(len(rows))
    for larger in range(1, _LEVELS):
        free = free[~np.isin(key(rows[free], larger), key(edge, larger))]
        level[free] = larger
    leaf, off_center = np.empty(len(rows), np.int64), np.empty(len(rows))
    for at in range(_LEVELS):
        here = np.flatnonzero(level == at)
        leaf[here] = key(rows[here], at) * _LEVELS + at
        off_center[here] = np.linalg.norm(place[rows[here]] / 2**at % 1.0 - 0.5, axis=1)
    return leaf, off_center
