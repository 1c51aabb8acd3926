"""Blue-noise cells: where the kept points of `lp_uniform` go, and how many of them.

The error of a reduced surface is about curvature times spacing squared. For a fixed number of points the
mean over the surface is least when the points are as dense as the root of the curvature; for the mean over
the originals, which eq. 27 takes, as the root of curvature times the density of the originals. Weights
between the two make cells of equal weight, and a power of the inverse distance tilts them so that the
selection keeps the density of each cluster (eq. 15) on average; the program then settles the rest.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.geometry.kernels import gather, principal_direction
from lpcompare.geometry.neighbors import Neighbors, Rows
from lpcompare.threads import for_blocks, map_in_threads
from lpcompare.types import Indices, Points, Vector

_AREA_EXPONENT = 0.75
_CURVATURE_EXPONENT = 0.5
_FLAT_SHARE = 0.15
_LLOYD_STEPS = 8
_LEAVES = 256
_TOP_LEVELS = 3
_FEW = 16
_TILT_RANGE = 8.0
_TILT_STEPS = 40
_TILT_PRECISION = 1e-10


def sampling_weights(areas: Vector, curvature: Vector) -> Vector:
    """Share of the budget that each point asks for.

    Parameters
    ----------
    areas : ndarray, shape (n,)
        Surface that each point stands for, in any unit.
    curvature : ndarray, shape (n,)
        Absolute curvature A of eq. 11. Flat regions count with 15 % of its mean, so that they stay covered.

    Returns
    -------
    ndarray, shape (n,)
        Positive.
    """
    weights = weights_in(
        areas, curvature, float(curvature.mean()), float(areas[areas > 0].min(initial=np.inf))
    )
    return weights / weights.mean()


def weights_in(areas: Vector, curvature: Vector, mean_curvature: float, smallest_area: float) -> Vector:
    """`sampling_weights` of a part of a cloud, up to a factor.

    Parameters
    ----------
    areas, curvature : ndarray, shape (n,)
        Of the part.
    mean_curvature, smallest_area : float
        Of the whole cloud; the least area above zero, or infinity where there is none.
    """
    floor = _FLAT_SHARE * mean_curvature
    bend = np.maximum(curvature, floor) if floor > 0 else np.ones_like(curvature)
    surface = np.maximum(areas, smallest_area) if np.isfinite(smallest_area) else np.ones_like(areas)
    return surface**_AREA_EXPONENT * bend**_CURVATURE_EXPONENT


def tilt_to_density(weights: Vector, costs: Vector, labels: Indices) -> Vector:
    """Multiply the weights of every cluster by the power of the cost at which their mean cost is one.

    Of all weights with that mean, a power of the cost departs least from the given ones in relative entropy
    per logarithm of the cost.

    Parameters
    ----------
    weights : ndarray, shape (n,)
        Positive.
    costs : ndarray, shape (n,)
        C_i of eq. 13 divided by the density of the point's cluster.
    labels : ndarray of int, shape (n,)

    Returns
    -------
    ndarray, shape (n,)
        The weight of each cluster as a whole stays as it was.
    """
    power = tilt_powers(weights, costs, labels, int(labels.max()) + 1)
    tilted = weights * np.exp(power[labels] * np.log(costs))
    before, after = (np.bincount(labels, w, len(power)) for w in (weights, tilted))
    return tilted * (before / np.where(after > 0, after, 1.0))[labels]


def tilt_powers(weights: Vector, costs: Vector, labels: Indices, n_clusters: int) -> Vector:
    """The power of each cluster of `tilt_to_density`, shape (n_clusters,)."""
    logs = np.log(costs)
    low, high = np.full(n_clusters, -_TILT_RANGE), np.full(n_clusters, _TILT_RANGE)
    power = np.zeros(n_clusters)
    for _ in range(_TILT_STEPS):
        tilted = weights * np.exp(power[labels] * logs)
        excess = np.bincount(labels, tilted * (costs - 1.0), n_clusters)
        slope = np.bincount(labels, tilted * (costs - 1.0) * logs, n_clusters)
        low, high = np.where(excess > 0, low, power), np.where(excess > 0, power, high)
        newton = power - np.divide(excess, slope, out=np.full(n_clusters, np.inf), where=slope > 0)
        before, power = power, np.where((low < newton) & (newton < high), newton, (low + high) / 2)
        if np.abs(power - before).max() < _TILT_PRECISION:
            break
    return power


def blue_noise_centers(tree: Neighbors, weights: Vector, n_cells: int) -> Points:
    """Centres of ``n_cells`` compact cells of nearly equal weight.

    The cloud is halved along its principal axis until there are exactly so many parts of equal weight, and
    Lloyd's relaxation rounds them.

    Parameters
    ----------
    tree : Neighbors
    weights : ndarray, shape (n,)
        Positive, in the order of ``tree.sorted_points``.
    n_cells : int
        From 1 to n.

    Returns
    -------
    ndarray, shape (n_cells, 3)
    """
    points, owners = tree.sorted_points, bisect(tree.sorted_points, weights, n_cells)
    centers = np.zeros((n_cells, 3))
    _move_to_centroids(points, weights, owners, centers)
    for _ in range(_LLOYD_STEPS):
        nearest_centers(tree, centers, owners)
        _move_to_centroids(points, weights, owners, centers)
    return centers


def nearest_centers(tree: Neighbors, centers: Points, owners: Rows) -> None:
    """Replace the owner of every point, in the order of ``tree``, by its nearest centre.

    The owners given bound the search: those of neighbouring points differ little, so that the few centres
    that may be nearest are looked up once for all points of a leaf.
    """
    over = Neighbors(centers)
    n_leaves = len(tree.leaves) - 1

    def assign(block: slice) -> None:
        _assign(
            tree.leaves[block.start : block.stop + 1],
            tree.sorted_points,
            centers,
            over.order,
            *over.arrays,
            owners,
        )

    for_blocks(n_leaves, assign, size=_LEAVES)


@njit(cache=True, nogil=True)
def _assign(leaves, points, centers, order, places, starts, boxes, owners):
    """`nearest_centers` for the leaves between the places ``leaves``."""
    found = np.empty(len(centers), np.int32)
    for leaf in range(len(leaves) - 1):
        begin, end = leaves[leaf], leaves[leaf + 1]
        low, high, reach = np.full(3, np.inf), np.full(3, -np.inf), 0.0
        for i in range(begin, end):
            for a in range(3):
                low[a], high[a] = min(low[a], points[i, a]), max(high[a], points[i, a])
            reach = max(reach, _squared_distance(points, i, centers, owners[i]))
        n_found = gather(low, high, reach, places, starts, boxes, found)
        for i in range(begin, end):
            least = _squared_distance(points, i, centers, owners[i])
            for place in found[:n_found]:
                distance = _squared_distance(points, i, places, place)
                if distance < least:
                    least, owners[i] = distance, order[place]


@njit(cache=True, nogil=True)
def _squared_distance(points, i, others, j):
    x, y, z = points[i, 0] - others[j, 0], points[i, 1] - others[j, 1], points[i, 2] - others[j, 2]
    return x * x + y * y + z * z


@njit(cache=True, nogil=True)
def _move_to_centroids(points, weights, owners, centers):
    """Move each centre to the weighted mean of its points; one without points stays."""
    totals, sums = np.zeros(len(centers)), np.zeros((len(centers), 3))
    for i in range(len(points)):
        totals[owners[i]] += weights[i]
        for a in range(3):
            sums[owners[i], a] += weights[i] * points[i, a]
    for cell in range(len(centers)):
        if totals[cell] > 0:
            centers[cell] = sums[cell] / totals[cell]


def bisect(points: Points, weights: Vector, n_cells: int) -> Rows:
    """Cell of every point: each part is halved along its principal axis until it is one cell.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    weights : ndarray, shape (n,)
    n_cells : int
        From 1 to n.

    Returns
    -------
    ndarray of int32, shape (n,)
        From 0 to ``n_cells`` - 1, every cell with a point.
    """
    cells, keys = np.zeros(len(points), dtype=np.int32), np.empty(len(points))
    state = points, weights.copy(), np.arange(len(points), dtype=np.int32), keys, cells
    parts = np.array([[0, len(points), 0, n_cells]])
    for _ in range(_TOP_LEVELS):
        halves = map_in_threads(lambda part: _bisect_part(part, 2, *state), list(parts))
        parts = np.concatenate(halves)
    map_in_threads(lambda part: _bisect_part(part, n_cells, *state), list(parts))
    return cells


@njit(cache=True, nogil=True)
def _bisect_part(part, most, points, weights, order, keys, cells):
    """Halve a part (begin, end, first cell, cells) until there are ``most`` parts or each is a cell."""
    parts = np.empty((min(part[3], most), 4), np.int64)
    parts[0], n_parts, at = part, 1, 0
    while at < n_parts:
        begin, end, first, n_cells = parts[at]
        if n_cells == 1:
            for i in range(begin, end):
                cells[order[i]] = first
            at += 1
        elif n_parts == len(parts):
            at += 1
        else:
            left = n_cells // 2
            _project(points, order, keys, begin, end)
            cut = _cut(weights, order, keys, begin, end, left, n_cells)
            parts[at, 1], parts[at, 3] = cut, left
            parts[n_parts, 0], parts[n_parts, 1] = cut, end
            parts[n_parts, 2], parts[n_parts, 3] = first + left, n_cells - left
            n_parts += 1
    return parts


@njit(cache=True, nogil=True)
def _project(points, order, keys, begin, end):
    """The positions of a part's points along its principal axis, whose largest component is positive."""
    rows = order[begin:end]
    x, y, z = principal_direction(points, rows)
    if -min(x, y, z) > max(x, y, z):
        x, y, z = -x, -y, -z
    for i in range(begin, end):
        row = order[i]
        keys[i] = x * points[row, 0] + y * points[row, 1] + z * points[row, 2]


@njit(cache=True, nogil=True)
def _cut(weights, order, keys, begin, end, left, n_cells):
    """Sort a part about the place where its weight is cut as ``left`` to the rest, a point for every cell."""
    total = weights[begin:end].sum()
    cut = _select(weights, order, keys, begin, end, total * left / n_cells, False)
    allowed = min(max(cut, begin + left), end - (n_cells - left))
    if allowed != cut:
        _select(weights, order, keys, begin, end, float(allowed - begin), True)
    return allowed


@njit(cache=True, nogil=True)
def _select(weights, order, keys, begin, end, wanted, counted):
    """Hoare's selection: the first place at which the points before it weigh (or count) ``wanted``."""
    low, high, passed = begin, end - 1, 0.0
    while high - low >= _FEW:
        a, b, c = keys[low], keys[(low + high) // 2], keys[high]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while keys[i] < pivot:
                i += 1
            while keys[j] > pivot:
                j -= 1
            if i <= j:
                _swap(weights, order, keys, i, j)
                i, j = i + 1, j - 1
        below = passed + _weight(weights, low, j + 1, counted)
        if below >= wanted:
            high = j
        else:
            passed = below + _weight(weights, j + 1, i, counted)
            if passed >= wanted:
                return i
            low = i
    for i in range(low + 1, high + 1):
        j = i
        while j > low and keys[j] < keys[j - 1]:
            _swap(weights, order, keys, j, j - 1)
            j -= 1
    for i in range(low, high + 1):
        passed += _weight(weights, i, i + 1, counted)
        if passed >= wanted:
            return i + 1
    return end


@njit(cache=True, nogil=True)
def _swap(weights, order, keys, i, j):
    weights[i], weights[j] = weights[j], weights[i]
    order[i], order[j] = order[j], order[i]
    keys[i], keys[j] = keys[j], keys[i]


@njit(cache=True, nogil=True)
def _weight(weights, begin, end, counted):
    return float(end - begin) if counted else weights[begin:end].sum()
