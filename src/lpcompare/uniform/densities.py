"""The density constraint of eqs. 24-25 as a guard: swaps may not take a cluster's density out of its band."""

from __future__ import annotations

import numpy as np

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
    counts : ndarray of int, shape (K,)
        Kept points of every cluster.
    sums : ndarray, shape (K,)
        Sum of C_i - 1 over them: the cluster's density is too high by ``sums / counts``.
    prices : ndarray, shape (2, K)
        What the error would fall by if the density might rise, and if it might fall, by one point's share more.
    """

    def __init__(
        self, labels: Indices, costs: Vector, tolerance: float = 0.01, offsets: Vector | None = None
    ) -> None:
        n_clusters = int(labels.max()) + 1 if offsets is None else len(offsets)
        self._offsets = np.zeros(n_clusters) if offsets is None else offsets
        self.labels, self.costs, self.tolerance = labels, costs, tolerance
        self.counts, self.sums = np.zeros(n_clusters, dtype=np.int64), np.zeros(n_clusters)
        self.prices = np.zeros((2, n_clusters))

    def start(self, kept: Indices, price: float) -> None:
        """Count the points ``kept``; a density outside its band costs ``price`` for each point's share."""
        n_clusters, labels = len(self.counts), self.labels[kept]
        self.counts = np.bincount(labels, minlength=n_clusters)
        self.sums = self._offsets + np.bincount(labels, self.costs[kept] - 1.0, n_clusters)
        room = self.tolerance * self.counts
        self.prices = np.maximum(self.prices, price * np.array([self.sums > room, self.sums < -room]))

    def pull(self) -> Vector:
        """What dropping each original is worth for the densities at the prices, shape (n,).

        Positive where the density should fall and the original adds to it, or should rise and it takes from it.
        """
        high, low = self.prices
        pull: Vector = (high - low)[self.labels] * (self.costs - 1.0)
        return pull
