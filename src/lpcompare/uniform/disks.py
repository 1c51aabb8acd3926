"""The radius at which Poisson disk sampling keeps a given number of points: the yardstick of the hole limit.

A maximal set of points that are a radius apart leaves no original farther from it than that radius. So the
radius says how far the farthest original is from an even sampling of the same size, on a cloud of any shape
and density.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.types import Points, Vector

SAMPLE = 12
"""Points looked at for each one kept."""
_TRIES = 12
_MANY, _PART = 20_000, 16
_TOLERANCE = 0.02
_DISKS_PER_SQUARE = 0.7


def disk_radius(points: Points, n_keep: int) -> float:
    """Radius at which about ``n_keep`` points of a maximal Poisson disk sampling remain.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Of more than 12 points for each one kept, only every so many is looked at.
    n_keep : int
        From 1 to n.

    Returns
    -------
    float
        In the unit of the points. On the points looked at, the count is within 2 % of ``n_keep`` where they
        allow it. On a denser cloud, of which they are a part, 7 to 10 % more were found: more points fit
        between the disks where there are more to choose from. 0 where the cloud has no extent.
    """
    sample = points[:: max(1, len(points) // (SAMPLE * n_keep))]
    order = np.random.default_rng(0).permutation(len(sample))
    sides = np.sort(np.ptp(points, axis=0))
    if sides[-1] == 0:
        return 0.0
    radius = _first_radius(sample, n_keep, sides)
    low, high = 0.0, np.inf
    table = np.empty(1 << (4 * n_keep).bit_length(), dtype=np.int32)
    for _ in range(_TRIES):
        count = count_disks(sample, order, radius, 2 * n_keep, table)
        if abs(count - n_keep) <= _TOLERANCE * n_keep:
            break
        low, high = (radius, high) if count > n_keep else (low, radius)
        radius *= float(np.clip(np.sqrt(count / n_keep), 0.5, 2.0))
        if not low < radius < high:
            radius = (low + high) / 2
    return radius


def _first_radius(sample: Points, n_keep: int, sides: Vector) -> float:
    """The first one tried: of many points, a part of both shows it at a small price."""
    if n_keep > _MANY:
        return disk_radius(sample[::_PART], n_keep // _PART) / _PART**0.5
    area = max(sides[-1] * sides[-2], sides[-1] ** 2 / n_keep)
    return float(np.sqrt(_DISKS_PER_SQUARE * area / n_keep))


@njit(cache=True, nogil=True)
def count_disks(points, order, radius, most, table):
    """How many rows `keep_disks` gives."""
    return len(keep_disks(points, order, radius, most, table))


@njit(cache=True, nogil=True)
def keep_disks(points, order, radius, most, table):
    """Rows that are kept when each is kept unless one within ``radius`` is; it ends above ``most``.

    ``table`` is the space of a hash table; its length is a power of two.
    """
    table[:] = -1
    following, rows = np.full(most + 1, -1, np.int32), np.empty(most + 1, np.int64)
    mask, count, square = len(table) - 1, 0, radius * radius
    for row in order:
        x, y, z = points[row]
        i, j, k = (
            np.int64(np.floor(x / radius)),
            np.int64(np.floor(y / radius)),
            np.int64(np.floor(z / radius)),
        )
        if count > most:
            break
        if _free(points, x, y, z, i, j, k, square, mask, table, following, rows):
            place = _place(i, j, k, mask)
            following[count], table[place], rows[count] = table[place], count, row
            count += 1
    return rows[:count]


@njit(cache=True, nogil=True)
def _free(points, x, y, z, i, j, k, square, mask, table, following, rows):
    """Whether no kept point is nearer than the radius."""
    for a in range(i - 1, i + 2):
        for b in range(j - 1, j + 2):
            for c in range(k - 1, k + 2):
                disk = table[_place(a, b, c, mask)]
                while disk >= 0:
                    row = rows[disk]
                    dx, dy, dz = points[row, 0] - x, points[row, 1] - y, points[row, 2] - z
                    if dx * dx + dy * dy + dz * dz < square:
                        return False
                    disk = following[disk]
    return True


@njit(cache=True, nogil=True)
def _place(i, j, k, mask):
    """Place of a grid cell in the hash table (Teschner and others, 2003)."""
    return (i * 73856093 ^ j * 19349663 ^ k * 83492791) & mask
