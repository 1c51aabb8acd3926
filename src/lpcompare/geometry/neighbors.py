"""k nearest neighbours: scipy's k-d tree, with the project's shapes and threads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lpcompare.geometry.threads import thread_count
from lpcompare.types import Points


class Neighbors:
    """A k-d tree over a cloud.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The cloud, finite, in model units.
    """

    def __init__(self, points: Points) -> None:
        self.points = points
        self._tree = KDTree(points, balanced_tree=False, compact_nodes=True)

    def query(self, queries: Points, n_neighbors: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Nearest rows of the cloud for each query point.

        Parameters
        ----------
        queries : ndarray, shape (q, 3)
        n_neighbors : int
            Neighbours per query; cut to the size of the cloud.

        Returns
        -------
        distances : ndarray, shape (q, k)
            Ascending, in model units.
        indices : ndarray of int, shape (q, k)
            Rows of the cloud.
        """
        k = min(n_neighbors, len(self.points))
        distances, indices = self._tree.query(queries, k=k, workers=thread_count())
        shape = (len(queries), k)
        return np.reshape(distances, shape), np.reshape(indices, shape)
