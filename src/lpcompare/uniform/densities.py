"""The density constraint of eqs. 24-25 as a guard: swaps may not take a cluster's density out of its band."""

from __future__ import annotations

import numpy as np
from numba import njit

from lpcompare.types import Indices, Vector


class DensityBand:
    """Mean cost of the kept points of every cluster, held near the cluster's density.

    Parameters
    ----------
    labels : ndarray of int, shape (n,)
        Cluster of each original, from 0 to K - 1.
    costs : ndarray, shape (n,)
        C_i of eq. 13, divided by the density D_c of its cluster.
    tolerance : float
        Largest Z of eq. 14, as a share of D_c, that a swap may lead to. A cluster that is farther out takes
        only what brings it closer.
    offsets : ndarray, shape (K,), optional
        What is added to the sums of the costs, for a part of a larger cloud: what the other parts have too much,
        less what they should have.

    Attributes
    ----------
    arrays : tuple
        What `lpcompare.uniform.swaps.pair_up` takes: labels, costs, the number of kept points and the sum of
        their costs in every cluster, tolerance.
    """

    def __init__(
        self, labels: Indices, costs: Vector, tolerance: float = 0.01, offsets: Vector | None = None
    ) -> None:
        n_clusters = int(labels.max()) + 1 if offsets is None else len(offsets)
        self._offsets = np.zeros(n_clusters) if offsets is None else offsets
        counts, sums = np.zeros(n_clusters, dtype=np.int64), np.zeros(n_clusters)
        self.arrays = labels, costs, counts, sums, tolerance

    def sorted(self, order: Indices) -> DensityBand:
        """The band for the originals ``order``."""
        labels, costs, _, _, tolerance = self.arrays
        return DensityBand(labels[order], costs[order], tolerance, self._offsets)

    def start(self, kept: Indices) -> None:
        """Count the points ``kept``."""
        labels, costs, counts, sums, _ = self.arrays
        counts[:] = np.bincount(labels[kept], minlength=len(counts))
        sums[:] = self._offsets + np.bincount(labels[kept], weights=costs[kept], minlength=len(counts))

    def pull(self) -> Vector:
        """How much dropping each original would bring its cluster back, in points' shares, shape (n,).

        Positive where the density is above its band and the original adds to it, or below and it takes from
        it; 0 in clusters that are in their band.
        """
        labels, costs, counts, sums, tolerance = self.arrays
        deviations = np.where(counts > 0, sums / np.maximum(counts, 1) - 1.0, 0.0)
        sides = np.where(np.abs(deviations) > tolerance, np.sign(deviations), 0.0)
        return sides[labels] * (costs - 1.0)


@njit(cache=True, nogil=True)
def deviation(total, count):
    """What the mean cost of a cluster's kept points differs from one by; 0 for a cluster without any."""
    return abs(total / count - 1.0) if count > 0 else 0.0
