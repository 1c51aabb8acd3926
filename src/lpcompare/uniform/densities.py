"""The density row of eqs. 24-25 as a guard: exchanges may not take a cluster's density out of its band."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices, Mask, Vector


class DensityBand:
    """Mean cost of the kept points of every cluster, held near the cluster's density.

    Parameters
    ----------
    labels : ndarray of int, shape (n,)
        Cluster of each original, from 0 to K - 1.
    costs : ndarray, shape (n,)
        C_i of eq. 13, divided by the density D_c of its cluster.
    tolerance : float
        Largest Z of eq. 14, as a share of D_c, that an exchange may lead to. A cluster that is farther out
        takes only what brings it closer.
    """

    def __init__(self, labels: Indices, costs: Vector, tolerance: float = 0.01) -> None:
        self._labels, self._costs, self._tolerance = labels, costs, tolerance
        self._sums: list[float] = []
        self._counts: list[int] = []

    def start(self, kept: Indices) -> None:
        """Count the points ``kept``."""
        n_clusters = int(self._labels.max()) + 1
        labels, costs = self._labels[kept], self._costs[kept]
        self._counts = np.bincount(labels, minlength=n_clusters).tolist()
        self._sums = np.bincount(labels, weights=costs, minlength=n_clusters).tolist()

    def wants(self, points: Indices, change: int) -> Mask:
        """Which of ``points``, taken in (1) or out (-1), bring a cluster back that is out of its band."""
        counts, sums = np.array(self._counts), np.array(self._sums)
        deviations = np.where(counts > 0, sums / np.maximum(counts, 1) - 1.0, 0.0)[self._labels[points]]
        pull = change * (self._costs[points] - 1.0) * deviations
        return (np.abs(deviations) > self._tolerance) & (pull < 0)

    def allows(self, point: int, change: int) -> bool:
        """Whether the cluster of ``point`` bears one point more (``change`` = 1) or less (-1)."""
        cluster = self._labels[point]
        count, total = self._counts[cluster], self._sums[cluster]
        after = self._deviation(total + change * self._costs[point], count + change)
        return after <= self._tolerance or after < self._deviation(total, count)

    def take(self, point: int, change: int) -> None:
        """Count ``point`` in (1) or out (-1)."""
        self._counts[self._labels[point]] += change
        self._sums[self._labels[point]] += change * self._costs[point]

    @staticmethod
    def _deviation(total: float, count: int) -> float:
        return abs(total / count - 1.0) if count > 0 else 0.0
