"""Farthest points by the distance along the surface, on a graph of neighbors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Indices, Points, Vector
from lpcompare_baselines._heap import heap_of, pop, settle
from lpcompare_baselines._hoods import normals_and_variation

_STEEPEST = 0.5
"""Sine of the angle to the surface, at both ends, from which an edge of the graph leaves it."""
_WIDEST_TURN = 0.5
"""Cosine of the angle between the normals at the ends of a long edge, below which the edge leaves the surface."""
_LONG = 2.0
"""Lengths of an edge over the spacing at its ends from which it is long."""
_SPACING_NEIGHBORS = 6
_SMALL = 32
"""Points up to which a part of the cloud without a way to the others is tied to its nearest point outside."""


class Surface(NamedTuple):
    """A graph whose shortest paths stand for distances along the surface.

    Attributes
    ----------
    starts : ndarray of int, shape (n + 1,)
    neighbors : ndarray of int, shape (e,)
        Those of point i are from ``starts[i]`` to ``starts[i + 1]``.
    lengths : ndarray, shape (e,)
        Length of each edge, in model units where the speed is 1.
    firsts : ndarray of int, shape (c,)
        The point of each connected part that is farthest from its center, the largest part first.
    """

    starts: Indices
    neighbors: Indices
    lengths: Vector
    firsts: Indices


def surface_graph(points: Points, n_neighbors: int, feature_weight: float = 0.0) -> Surface:
    """Graph of the nearest neighbors, without edges that leave the surface.

    An edge leaves the surface when it stands steep on the tangent planes of both ends, or when it is long and
    the normals at its ends differ by more than 60 degrees. Small parts without a way to others are tied to
    their nearest point outside.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    n_neighbors : int
    feature_weight : float, optional
        How much slower paths are where the surface varies: the speed is ``1 / (1 + feature_weight * s)``, with
        the surface variation s in units of its mean. An edge's length is divided by the mean speed of its ends.
    """
    distances, neighbors = nearest_others(points, n_neighbors)
    normals, variation = normals_and_variation(points, neighbors)
    spacing = distances[:, :_SPACING_NEIGHBORS].sum(axis=1) / _SPACING_NEIGHBORS
    first, second = _pairs(neighbors)
    offsets = points[second] - points[first]
    lengths = np.linalg.norm(offsets, axis=1)
    steep = [
        np.abs(np.einsum("ei,ei->e", offsets, normals[end])) > _STEEPEST * lengths for end in (first, second)
    ]
    turned = np.abs(np.einsum("ei,ei->e", normals[first], normals[second])) < _WIDEST_TURN
    long = lengths > _LONG * np.minimum(spacing[first], spacing[second])
    stays = ~(steep[0] & steep[1]) & ~(turned & long)
    first, second, part = _tied(points, first[stays], second[stays])
    speed = 1.0 / (1.0 + feature_weight * variation / (variation.mean() or 1.0))
    lengths = np.linalg.norm(points[second] - points[first], axis=1) * 2.0 / (speed[first] + speed[second])
    ends = np.concatenate([first, second]), np.concatenate([second, first])
    graph = coo_array((np.tile(lengths, 2), ends), (len(points), len(points))).tocsr()
    return Surface(
        graph.indptr.astype(np.int64),
        graph.indices.astype(np.int64),
        np.asarray(graph.data, float),
        _part_firsts(points, part),
    )


def geodesic_farthest_points(surface: Surface, target_count: int) -> tuple[Indices, Vector]:
    """Rows in greedy order, each one farthest along the surface from those before it.

    Returns
    -------
    order : ndarray of int, shape (target_count,)
        Each part's first point, the largest part first; then the greedy choice, the lowest row where distances
        tie. The beginning of a longer order is the shorter one.
    distances : ndarray, shape (n,)
        From each point to the nearest one chosen, infinite in parts that have none.
    """
    return _march_all(surface.starts, surface.neighbors, surface.lengths, surface.firsts, target_count)


def _pairs(neighbors: Indices) -> tuple[Indices, Indices]:
    """The edges of a neighbor table (n, k), each once, as lower and higher rows."""
    n = len(neighbors)
    rows = np.repeat(np.arange(n), neighbors.shape[1])
    low, high = np.minimum(rows, neighbors.ravel()), np.maximum(rows, neighbors.ravel())
    return np.divmod(np.unique(low * n + high), n)


def _tied(points: Points, first: Indices, second: Indices) -> tuple[Indices, Indices, Indices]:
    """The edges, with those added that tie small parts to the rest, and the part of each point."""
    n, tree = len(points), Neighbors(points)
    while True:
        edges = coo_array((np.ones(len(first)), (first, second)), (n, n))
        n_parts, part = connected_components(edges, directed=False)
        lonely = np.flatnonzero(np.bincount(part)[part] <= _SMALL)
        if n_parts == 1 or len(lonely) == 0:
            return first, second, part
        # among as many points and one more, the nearest of them lies outside
        distances, near = tree.query(points[lonely], _SMALL + 1)
        outside = part[near] != part[lonely][:, None]
        nearest = outside.argmax(axis=1)[:, None]
        distance = np.take_along_axis(distances, nearest, axis=1)[:, 0]
        other = np.take_along_axis(near, nearest, axis=1)[:, 0]
        order = np.lexsort((distance, part[lonely]))
        best = order[np.diff(part[lonely][order], prepend=-1) > 0]
        first, second = np.append(first, lonely[best]), np.append(second, other[best])
        low, high = np.minimum(first, second), np.maximum(first, second)
        first, second = np.divmod(np.unique(low * n + high), n)


def _part_firsts(points: Points, part: Indices) -> Indices:
    """The point of each part that is farthest from its part's center, the largest part first."""
    sizes = np.bincount(part)
    origin = points.mean(axis=0)
    centers = np.column_stack([np.bincount(part, column) for column in (points - origin).T]) / sizes[:, None]
    squared = np.square(points - origin - centers[part]).sum(axis=1)
    order = np.lexsort((np.arange(len(points)), -squared, part, -sizes[part]))
    return order[np.diff(part[order], prepend=-1) != 0]


@njit("void(i8, i8[::1], i8[::1], f8[::1], f8[::1], i8[::1], i8[::1])", cache=True)
def _march(source, starts, neighbors, lengths, distances, heap, place):
    """Dijkstra's algorithm from one point, only where it comes nearer than those before."""
    distances[source] = 0.0
    heap[0], place[source], size = source, 0, 1
    while size:
        row = pop(heap, size, place, distances)
        size -= 1
        for edge in range(starts[row], starts[row + 1]):
            other, distance = neighbors[edge], distances[row] + lengths[edge]
            if distance < distances[other]:
                distances[other] = distance
                if place[other] < 0:
                    heap[size], place[other] = other, size
                    size += 1
                settle(place[other], heap, size, place, distances)


@njit("Tuple((i8[::1], f8[::1]))(i8[::1], i8[::1], f8[::1], i8[::1], i8)", cache=True)
def _march_all(starts, neighbors, lengths, firsts, target_count):
    n = len(starts) - 1
    order, distances = np.empty(target_count, np.int64), np.full(n, np.inf)
    heap, place = np.empty(n, np.int64), np.full(n, -1)
    n_firsts = min(len(firsts), target_count)
    for at in range(n_firsts):
        order[at] = firsts[at]
        _march(firsts[at], starts, neighbors, lengths, distances, heap, place)
    # distances only shrink: an entry of the second heap is brought up to date when it comes to the top
    keys = -distances
    far, far_place = heap_of(keys)
    size = n
    chosen = np.zeros(n, np.bool_)
    chosen[order[:n_firsts]] = True
    at = n_firsts
    while at < target_count:
        row = far[0]
        if not chosen[row] and keys[row] != -distances[row]:
            keys[row] = -distances[row]
            settle(0, far, size, far_place, keys)
            continue
        pop(far, size, far_place, keys)
        size -= 1
        if not chosen[row]:
            order[at], chosen[row] = row, True
            at += 1
            _march(row, starts, neighbors, lengths, distances, heap, place)
    return order, distances
