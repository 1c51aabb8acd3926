"""Blue-noise cells: where the kept points of `lp_uniform` go, and how many of them.

The error of a reduced surface is about curvature times spacing squared. For a fixed number of points the
mean over the surface is least when the points are as dense as the root of the curvature; for the mean over
the originals, which eq. 27 takes, as the root of curvature times the density of the originals. Weights
between the two make cells of equal weight, and a power of the inverse distance tilts them so that the
selection keeps the density of each cluster (eq. 15) on average; the programme then settles the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Indices, Points, Vector

_AREA_EXPONENT = 0.75
_CURVATURE_EXPONENT = 0.5
_FLAT_SHARE = 0.15
_LLOYD_STEPS = 8
_TILT_RANGE = 8.0
_TILT_STEPS = 40


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
    floor = _FLAT_SHARE * float(curvature.mean())
    bend = np.maximum(curvature, floor) if floor > 0 else np.ones_like(curvature)
    smallest = float(areas[areas > 0].min(initial=np.inf))
    surface = np.maximum(areas, smallest) if np.isfinite(smallest) else np.ones_like(areas)
    weights = surface**_AREA_EXPONENT * bend**_CURVATURE_EXPONENT
    return weights / weights.mean()


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
    logs = np.log(costs)
    n_clusters = int(labels.max()) + 1
    low, high = np.full(n_clusters, -_TILT_RANGE), np.full(n_clusters, _TILT_RANGE)
    for _ in range(_TILT_STEPS):
        middle = (low + high) / 2
        tilted = weights * np.exp(middle[labels] * logs)
        totals = np.bincount(labels, tilted, n_clusters)
        above = np.bincount(labels, tilted * costs, n_clusters) > totals
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    tilted = weights * np.exp(low[labels] * logs)
    before, after = (np.bincount(labels, w, n_clusters) for w in (weights, tilted))
    return tilted * (before / np.where(after > 0, after, 1.0))[labels]


def blue_noise_centers(points: Points, weights: Vector, n_cells: int) -> Points:
    """Centres of ``n_cells`` compact cells of nearly equal weight.

    The cloud is halved along its principal axis until there are exactly so many parts of equal weight, and
    Lloyd's relaxation rounds them.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    weights : ndarray, shape (n,)
        Positive.
    n_cells : int
        From 1 to n.

    Returns
    -------
    ndarray, shape (n_cells, 3)
    """
    centers, _ = _centroids(points, weights, _bisect(points, weights, n_cells), n_cells)
    for _ in range(_LLOYD_STEPS):
        owners = Neighbors(centers).query(points, 1)[1][:, 0]
        moved, occupied = _centroids(points, weights, owners, n_cells)
        centers = np.where(occupied[:, None], moved, centers)
    return centers


def _centroids(
    points: Points, weights: Vector, owners: Indices, n_cells: int
) -> tuple[Points, NDArray[np.bool_]]:
    """Weighted mean of each cell, and whether the cell has a point."""
    totals = np.bincount(owners, weights, n_cells)
    occupied = totals > 0
    sums = np.stack([np.bincount(owners, weights * column, n_cells) for column in points.T], axis=1)
    return sums / np.where(occupied, totals, 1.0)[:, None], occupied


def _bisect(points: Points, weights: Vector, n_cells: int) -> Indices:
    """Cell of every point: all parts of one level are halved at once, each along its principal axis."""
    cells = np.empty(len(points), dtype=np.intp)
    rows, starts, counts, firsts = (
        np.arange(len(points)),
        np.zeros(1, int),
        np.array([n_cells]),
        np.zeros(1, int),
    )
    while len(rows):
        sizes = np.diff(starts, append=len(rows))
        single = counts == 1
        cells[rows[np.repeat(single, sizes)]] = np.repeat(firsts[single], sizes[single])
        rows, sizes = rows[np.repeat(~single, sizes)], sizes[~single]
        counts, firsts = counts[~single], firsts[~single]
        if not len(rows):
            break
        starts = np.cumsum(sizes) - sizes
        rows = _sort_along_axes(points, rows, starts, sizes)
        left = counts // 2
        cuts = _cuts(weights[rows], starts, sizes, counts, left)
        starts = np.column_stack([starts, cuts]).ravel()
        firsts = np.column_stack([firsts, firsts + left]).ravel()
        counts = np.column_stack([left, counts - left]).ravel()
    return cells


def _sort_along_axes(points: Points, rows: Indices, starts: Indices, sizes: Indices) -> Indices:
    """The rows of each part in the order of their position along the part's principal axis."""
    part = np.repeat(np.arange(len(sizes)), sizes)
    offsets = points[rows]
    offsets = offsets - (np.add.reduceat(offsets, starts) / sizes[:, None])[part]
    covariances = np.empty((len(sizes), 3, 3))
    for i in range(3):
        for j in range(i + 1):
            covariances[:, i, j] = covariances[:, j, i] = np.add.reduceat(
                offsets[:, i] * offsets[:, j], starts
            )
    axes = np.linalg.eigh(covariances)[1][:, :, 2]
    # the sign of an eigenvector is arbitrary: make its largest component positive
    largest = np.take_along_axis(axes, np.abs(axes).argmax(axis=1)[:, None], axis=1)
    positions = np.einsum("ni,ni->n", offsets, (axes * np.sign(largest))[part])
    return rows[np.lexsort((positions, part))]


def _cuts(weights: Vector, starts: Indices, sizes: Indices, counts: Indices, left: Indices) -> Indices:
    """Where each part is cut so that its halves weigh as ``left`` to the rest, a point for every cell."""
    running = np.cumsum(weights)
    before = running[starts] - weights[starts]
    total = running[starts + sizes - 1] - before
    cuts = np.searchsorted(running, before + total * left / counts) + 1
    return np.clip(cuts, starts + left, starts + sizes - (counts - left))
