"""Points that uniformly distributed lines meet: each piece of the surface gets its share by area.

J. Rovira, P. Wonka, F. Castro and M. Sbert, Point sampling with uniformly distributed lines, Eurographics/IEEE VGTC
Symposium on Point-Based Graphics, 2005, 109-118; the 2017 paper's [7]. Only the abstract could be read, and it speaks
of polygonal models: lines are cast through the model, and their crossings with it are the samples. A line of a
uniform distribution crosses every piece of surface with a chance that depends on its area alone (Cauchy and
Crofton). This file is our version for points, a reading.

Decisions:

- A point stands for a disc in its tangent plane, as wide as the distance to its sixth neighbor,
  at most ten times the median of that. A line crosses the surface where it meets discs; discs of one sheet
  are one crossing (next along the line by less than the sum of
  their radii, normals within 60 degrees). The disc met nearest its center gives the sample.
- Lines come in bundles of parallel ones, one at a random place in each cell of a square grid. Directions follow the
  R2 sequence (Roberts 2018), from a random start. The pitch of the grid is chosen so that about ``n_bundles``
  bundles give the count: by Cauchy and Crofton a bundle of pitch h crosses an area A in ``A / (2 h^2)`` places.
- A crossing whose nearest disc has been taken gives the nearest disc that has not, so that no area loses its share
  because its points are few.
- Discs seen at a flatter angle than 6 degrees are not met: whether a line meets them is chance. All directions of
  a surface lose the same by it.
- Points that no line met when the bundles stop giving new ones follow in random order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Indices, Mask, Points, Simplification, Traits, Vector
from lpcompare_baselines._hoods import normals_and_variation

TRAITS = Traits(
    wraps="lpcompare (numpy, scipy)",
    source="Rovira, Wonka, Castro and Sbert, Point sampling with uniformly distributed lines, "
    "Symposium on Point-Based Graphics, 2005 (abstract)",
    family="random",
    reading=True,
)

_NORMAL_NEIGHBORS = 16
_RADIUS_NEIGHBORS = 6
_FLATTEST = 0.1
_SAME_SHEET = 0.5
_WIDEST = 10.0
"""Radius of a disc over the median radius, at most: a far outlier is not a surface."""
_R2 = 0.7548776662466927, 0.5698402909980532
_MOST_BUNDLES = 40
"""Bundles, over those expected, after which the rest is drawn."""


def rovira_lines(
    points: Points, target_count: int, *, rng: np.random.Generator, n_bundles: int = 64
) -> Simplification:
    """Keep ``target_count`` points that lines meet.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the first direction, the place of each line in its cell, and the order within a bundle.
    n_bundles : int, optional
        Directions in which lines are cast, about.

    Returns
    -------
    Simplification
        A subset of the input; ``info["n_bundles"]`` is the number of directions used, ``info["n_drawn"]`` the
        number of points that no line gave.
    """
    discs = _Discs(points)
    pitch = np.sqrt(0.5 * discs.area * n_bundles / target_count)
    taken = np.zeros(len(points), bool)
    n_taken, bundle, start = 0, 0, rng.random(2)
    while n_taken < target_count and pitch > 0 and bundle < _MOST_BUNDLES * n_bundles:
        direction = _direction((start + np.multiply(bundle, _R2)) % 1.0)
        rows = discs.met(direction, pitch, taken, rng)
        rows = rng.permutation(rows)[: target_count - n_taken]
        taken[rows] = True
        n_taken += len(rows)
        bundle += 1
    missing = rng.permutation(np.flatnonzero(~taken))[: target_count - n_taken]
    taken[missing] = True
    indices = np.flatnonzero(taken)
    return Simplification(points[indices], indices, info={"n_bundles": bundle, "n_drawn": len(missing)})


class _Discs:
    """One disc per point, in its tangent plane."""

    def __init__(self, points: Points) -> None:
        distances, neighbors = nearest_others(points, _NORMAL_NEIGHBORS)
        self.points = points - points.mean(axis=0)
        self.normals, _ = normals_and_variation(points, neighbors)
        radii = distances[:, :_RADIUS_NEIGHBORS].max(axis=1, initial=0.0)
        self.radii = np.minimum(radii, _WIDEST * np.median(radii))
        self.area = float(np.pi * np.square(self.radii).sum() / _RADIUS_NEIGHBORS)

    def met(self, direction: Vector, pitch: float, taken: Mask, rng: np.random.Generator) -> Indices:
        """Rows that a bundle of lines gives, one per crossing, none twice."""
        row, line, depth, aside = self._meetings(direction, pitch, rng)
        order = np.lexsort((depth, line))
        row, line, depth, aside = row[order], line[order], depth[order], aside[order]
        apart = np.abs(np.einsum("hi,hi->h", self.normals[row[1:]], self.normals[row[:-1]])) < _SAME_SHEET
        far = np.diff(depth) > self.radii[row[1:]] + self.radii[row[:-1]]
        crossing = np.concatenate([[0], np.cumsum((np.diff(line) > 0) | far | apart)])[: len(row)]
        # the nearest disc of each crossing, those taken after all others
        order = np.lexsort((aside, taken[row], crossing))
        best = order[np.diff(crossing[order], prepend=-1) > 0]
        return np.unique(row[best][~taken[row[best]]])

    def _meetings(
        self, direction: Vector, pitch: float, rng: np.random.Generator
    ) -> tuple[Indices, Indices, Vector, Vector]:
        """Every disc that a line meets: its row, the line, the depth there, the distance to the disc's center."""
        facing = np.flatnonzero(np.abs(self.normals @ direction) >= _FLATTEST)
        across = _plane_axes(direction)
        flat = (self.points[facing] @ across.T) / pitch + rng.random(2)
        reach = self.radii[facing, None] / pitch
        low = flat.min(axis=0, initial=0.0) - reach.max(initial=0.0)
        first = np.floor(flat - reach - low).astype(np.int64)
        n_cells = np.floor(flat + reach - low).astype(np.int64) - first + 1
        width = int((first + n_cells).max(initial=0)) + 1
        which, cell = _cells_of(first, n_cells)
        number = cell[:, 0] * width + cell[:, 1]
        lines, line = np.unique(number, return_inverse=True)
        places = (cell + low + rng.random((len(lines), 2))[line] - flat[which]) * pitch
        row = facing[which]
        # along the line from the foot of the center to the tangent plane
        offset = places @ across
        rise = -np.einsum("hi,hi->h", offset, self.normals[row]) / (self.normals[row] @ direction)
        aside = np.sqrt(np.square(offset).sum(axis=1) + rise**2)
        met = aside <= self.radii[row]
        depth = self.points[row] @ direction + rise
        return row[met], line[met], depth[met], aside[met]


def _cells_of(first: NDArray[np.int64], n_cells: NDArray[np.int64]) -> tuple[Indices, NDArray[np.int64]]:
    """Every cell (c, 2) of the rectangles that begin at ``first`` and count ``n_cells``, and whose it is."""
    n_each = n_cells.prod(axis=1)
    which = np.repeat(np.arange(len(first)), n_each)
    place = np.arange(len(which)) - np.repeat(np.cumsum(n_each) - n_each, n_each)
    return which, first[which] + np.column_stack(np.divmod(place, n_cells[which, 1]))


def _direction(pair: Vector) -> Vector:
    """The point of the unit sphere for two numbers from 0 to 1, equal areas for equal areas."""
    height, angle = 1.0 - 2.0 * pair[0], 2.0 * np.pi * pair[1]
    ring = np.sqrt(max(1.0 - height**2, 0.0))
    return np.array([ring * np.cos(angle), ring * np.sin(angle), height])


def _plane_axes(direction: Vector) -> Points:
    """Two unit vectors (2, 3) at right angles to a direction and to each other."""
    return np.linalg.svd(direction[None])[2][1:]
