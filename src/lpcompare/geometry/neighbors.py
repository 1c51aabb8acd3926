"""k nearest neighbours: scipy's k-d tree, with the project's shapes and threads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lpcompare.threads import thread_count
from lpcompare.types import Indices, Points


class Neighbors:
    """A k-d tree over a cloud.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The cloud, finite, in model units.
    """

    def __init__(self, points: Points) -> None:
        self.points = points
        self._tree = KDTree(points, balanced_tree=False, compact_nodes=True, leafsize=32)

    @property
    def spatial_order(self) -> Indices:
        """Every row once, near rows together, shape (n,): queries in this order find the tree in cache."""
        return self._tree.indices

    def query(
        self, queries: Points, n_neighbors: int, *, n_threads: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Nearest rows of the cloud for each query point.

        Parameters
        ----------
        queries : ndarray, shape (q, 3)
        n_neighbors : int
            Neighbours per query; cut to the size of the cloud.
        n_threads : int, optional
            By default `thread_count`; 1 where the caller already runs in one of several threads.

        Returns
        -------
        distances : ndarray, shape (q, k)
            Ascending, in model units.
        indices : ndarray of int, shape (q, k)
            Rows of the cloud.
        """
        k = min(n_neighbors, len(self.points))
        distances, indices = self._tree.query(queries, k=k, workers=n_threads or thread_count())
        shape = (len(queries), k)
        return np.reshape(distances, shape), np.reshape(indices, shape)
