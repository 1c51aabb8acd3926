"""Stratified random choice: one point of each of equally large strata (numpy).

The points are put in the order of a space-filling curve (Morton's) and cut into as many strata as points are
wanted; one row of each is drawn. The strata hold equal numbers of points, so dense regions stay dense.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Points, Simplification, Traits

TRAITS = Traits(
    family="voxel",
    wraps="numpy",
    source="Cochran, Sampling Techniques, Wiley 1977, chapter 5; Morton, A computer oriented geodetic data "
    "base, IBM 1966",
    licence="BSD-3-Clause",
)

_BITS = 21


def stratified_sample(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep one random row of each of ``target_count`` strata.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator

    Returns
    -------
    Simplification
        A subset of the input.
    """
    order = np.argsort(_morton_codes(points), kind="stable")
    borders = np.arange(target_count + 1) * len(points) // target_count
    indices = np.sort(order[rng.integers(borders[:-1], borders[1:])])
    return Simplification(points[indices], indices)


def _morton_codes(points: Points) -> NDArray[np.uint64]:
    """Position of each point along the curve: the bits of its three coordinates, interleaved."""
    side = float(np.ptp(points, axis=0).max()) or 1.0
    cells = ((points - points.min(axis=0)) / side * (2**_BITS - 1)).astype(np.uint64)
    codes = np.zeros(len(points), np.uint64)
    for bit in range(_BITS):
        for axis in range(3):
            codes |= ((cells[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return codes
