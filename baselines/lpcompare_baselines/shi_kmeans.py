"""Clusters of a given width, those with unlike normals split in two again and again: a reading of Shi 2011.

B.-Q. Shi, J. Liang and Q. Liu, Adaptive simplification of point cloud using k-means clustering, Computer-Aided Design
43(8), 2011, 910-922. The text could not be read; the steps come from the 2017 paper, which describes this method under
its number [9] (``docs/related-work.md`` says more). The user gives a space interval DT and a normal deviation NT:

1. each point not yet in a cluster begins one, of all points within DT that are in none;
2. clusters with fewer than six others within sqrt(3) DT lie on a boundary and are treated apart;
3. a cluster whose normals deviate by NT or more is split by k-means with k = 2 that begins at the two points whose
   normals deviate most, and so on; the deviation of two normals at an angle a is ``sqrt(1 - cos a)``;
4. one point stands for each cluster: here the point nearest its centroid.

Decisions:

- The count decides DT and NT. DT is the one that gives about half as many clusters as points are asked for. Then the
  cluster of largest deviation is split until the count is reached; so NT is what the count leaves, and
  ``info["normal_deviation"]`` says it. Where deviations are equal, as on a plane, the largest cluster is split.
- A boundary cluster keeps its points on the rim of the surface, each as a cluster of its own, so that the boundary
  does not shrink. They may take ``rim_share`` of the result; where there are more, those farthest apart are kept.
- Normals have no sign. In clusters of more than 64 points the two farthest normals are sought in two sweeps.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.spatial import KDTree

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Indices, Mask, Points, Simplification, Traits
from lpcompare_baselines._calibration import search_size, surface_spacing
from lpcompare_baselines._heap import pop, settle
from lpcompare_baselines._hoods import normals_and_variation, on_rim, thinned
from lpcompare_baselines._plane_kernel import dot

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy, numba)",
    source="Shi, Liang and Liu, Adaptive simplification of point cloud using k-means clustering, "
    "Computer-Aided Design 43(8), 2011",
    family="clustering",
    reading=True,
)

_NORMAL_NEIGHBORS = 16
_FULL_RING = 6
_COVER_SHARE = 0.5
_COVER_TOLERANCE = 0.05
_WIDER = 1.25
_PAIRS_UP_TO = 64
_MEANS_STEPS = 10
_PER_MEMBER = 1e-6
"""Deviation that one member more is worth: it decides between clusters that are equally flat."""


def shi_kmeans(
    points: Points, target_count: int, *, rng: np.random.Generator, rim_share: float = 0.25
) -> Simplification:
    """Keep one point per cluster.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    rim_share : float, optional
        Largest share of the result that rim points take, from 0 to below 1.

    Returns
    -------
    Simplification
        A subset of the input. ``info["space_interval"]`` is DT in model units, ``info["normal_deviation"]`` the
        largest deviation left in a cluster, from 0 to 1.
    """
    _, neighbors = nearest_others(points, _NORMAL_NEIGHBORS)
    normals, _ = normals_and_variation(points, neighbors)
    rim = on_rim(points, neighbors, normals)
    interval, cluster, kept = _first_clusters(points, rim, target_count, int(rim_share * target_count))
    inner = np.flatnonzero(~np.isin(np.arange(len(points)), kept))
    members = inner[np.argsort(cluster[inner], kind="stable")]
    starts = np.flatnonzero(np.diff(cluster[members], prepend=-1))
    ends, deviation = _split(points - points.mean(axis=0), normals, members, starts, target_count - len(kept))
    indices = np.sort(np.concatenate([kept, _nearest_to_centroid(points, members, np.sort(ends))]))
    info = {"space_interval": interval, "normal_deviation": deviation, "n_rim": len(kept)}
    return Simplification(points[indices], indices, info=info)


def _first_clusters(
    points: Points, rim: Mask, target_count: int, most_rim: int
) -> tuple[float, Indices, Indices]:
    """Space interval, cluster of each point and the rim points kept: fewer clusters than points are asked for."""
    tree = KDTree(points)
    wanted = max(1, int(_COVER_SHARE * target_count))
    interval = search_size(
        lambda size: int(cover(points, tree, size).max()) + 1,
        wanted,
        surface_spacing(points, wanted),
        tolerance=int(_COVER_TOLERANCE * wanted),
        max_calls=20,
    )
    while True:
        cluster = cover(points, tree, interval)
        on_boundary = _is_boundary(points, cluster, interval)[cluster]
        kept = thinned(points, np.flatnonzero(rim & on_boundary), most_rim)
        inner = np.delete(cluster, kept)
        if len(np.unique(inner)) <= target_count - len(kept):
            return interval, cluster, kept
        interval *= _WIDER


def cover(points: Points, tree: KDTree, interval: float) -> Indices:
    """Cluster of each point: points in the input's order begin one where they are in none, of all that are near."""
    cluster, n_clusters = np.full(len(points), -1), 0
    for row, point in enumerate(points):
        if cluster[row] < 0:
            near = np.asarray(tree.query_ball_point(point, interval))
            cluster[near[cluster[near] < 0]] = n_clusters
            n_clusters += 1
    return cluster


def _is_boundary(points: Points, cluster: Indices, interval: float) -> Mask:
    """Whether fewer than six other centroids lie within sqrt(3) intervals of each cluster's."""
    n_in, origin = np.bincount(cluster), points.mean(axis=0)
    centroids = np.column_stack([np.bincount(cluster, c) for c in (points - origin).T]) / n_in[:, None]
    around = KDTree(centroids).query_ball_point(centroids, np.sqrt(3.0) * interval, return_length=True)
    return np.asarray(around) - 1 < _FULL_RING


def _nearest_to_centroid(points: Points, members: Indices, ends: Indices) -> Indices:
    """The member of each cluster that is nearest its centroid."""
    starts = np.concatenate([[0], ends[:-1]])
    sizes = ends - starts
    own = np.repeat(np.arange(len(ends)), sizes)
    offsets = points[members] - points[members[starts]][own]
    centroids = np.add.reduceat(offsets, starts) / sizes[:, None]
    squared = np.square(offsets - centroids[own]).sum(axis=1)
    return members[np.lexsort((members, squared, own))[starts]]


@njit("Tuple((f8, i8, i8))(f8[:,::1], i8[::1])", cache=True)
def largest_deviation(normals, members):
    """The two members whose normals deviate most, and by how much, from 0 to 1."""
    least, first, second = 2.0, 0, 0
    sweeps = len(members) > _PAIRS_UP_TO
    for i in range(2 if sweeps else len(members)):
        row = second if sweeps else i
        for j in range(0 if sweeps else i + 1, len(members)):
            cosine = abs(dot(normals[members[row]], normals[members[j]]))
            if cosine < least:
                least, first, second = cosine, row, j
    return np.sqrt(max(1.0 - least, 0.0)) if least < 2.0 else 0.0, first, second


@njit("i8(f8[:,::1], i8[::1], i8, i8)", cache=True)
def two_means(points, members, first, second):
    """Sort members into two groups by Lloyd's steps from two of them; returns the size of the first group."""
    means, sizes = np.empty((2, 3)), np.zeros(2)
    means[0], means[1] = points[members[first]], points[members[second]]
    group = np.zeros(len(members), np.int64)
    for _ in range(_MEANS_STEPS):
        sums, sizes = np.zeros((2, 3)), np.zeros(2)
        for i in range(len(members)):
            first_squared, second_squared = 0.0, 0.0
            for c in range(3):
                first_squared += (points[members[i], c] - means[0, c]) ** 2
                second_squared += (points[members[i], c] - means[1, c]) ** 2
            group[i] = 1 if second_squared < first_squared else 0
            for c in range(3):
                sums[group[i], c] += points[members[i], c]
            sizes[group[i]] += 1
        if sizes.min() == 0:  # all in one place
            return len(members) // 2
        for g in range(2):
            means[g] = sums[g] / sizes[g]
    places, before = np.zeros(2, np.int64), members.copy()
    places[1] = int(sizes[0])
    for i in range(len(members)):
        members[places[group[i]]] = before[i]
        places[group[i]] += 1
    return int(sizes[0])


@njit("i8(i8, i8, i8[::1], i8, i8[::1], f8[::1])", cache=True)
def _enter(cluster, n_members, heap, size, place, keys):
    """Put a cluster that can be split on the heap by its key; returns the heap's size."""
    if n_members < 2:
        return size
    keys[cluster] -= _PER_MEMBER * n_members
    heap[size] = cluster
    settle(size, heap, size + 1, place, keys)
    return size + 1


@njit("Tuple((i8[::1], f8))(f8[:,::1], f8[:,::1], i8[::1], i8[::1], i8)", cache=True)
def _split(points, normals, members, first_starts, target_count):
    """Split clusters, slices of ``members``, until there are enough; returns their ends and the deviation left."""
    starts, ends = np.empty(target_count, np.int64), np.empty(target_count, np.int64)
    heap, place, keys = np.empty(target_count, np.int64), np.full(target_count, -1), np.empty(target_count)
    pairs, deviations = np.empty((target_count, 2), np.int64), np.zeros(target_count)
    n, size = len(first_starts), 0
    starts[:n], ends[: n - 1], ends[n - 1] = first_starts, first_starts[1:], len(members)
    for c in range(n):
        deviations[c], pairs[c, 0], pairs[c, 1] = largest_deviation(normals, members[starts[c] : ends[c]])
        keys[c] = -deviations[c]
        size = _enter(c, ends[c] - starts[c], heap, size, place, keys)
    while n < target_count:
        parent = pop(heap, size, place, keys)
        size -= 1
        both = members[starts[parent] : ends[parent]]
        middle = starts[parent] + two_means(points, both, pairs[parent, 0], pairs[parent, 1])
        starts[n], ends[n], ends[parent] = middle, ends[parent], middle
        for c in (parent, n):
            deviations[c], pairs[c, 0], pairs[c, 1] = largest_deviation(normals, members[starts[c] : ends[c]])
            keys[c] = -deviations[c]
            size = _enter(c, ends[c] - starts[c], heap, size, place, keys)
        n += 1
    return ends, deviations.max()
