"""Each point's nearest other points, and the graph that joins them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.types import Points, Vector


def nearest_others(points: Points, n_neighbors: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distances and rows of each point's nearest other points, nearest first.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    n_neighbors : int
        Cut to n - 1.

    Returns
    -------
    distances : ndarray, shape (n, k)
        Ascending, in model units.
    rows : ndarray of int, shape (n, k)
        Never the point's own row, but there may be rows at the same position.

    Examples
    --------
    >>> import numpy as np
    >>> line = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    >>> nearest_others(line, 1)[1].ravel()
    array([1, 0, 1])
    """
    n, k = len(points), min(n_neighbors, len(points) - 1)
    distances, rows = Neighbors(points).query(points, k + 1)
    own = rows == np.arange(n)[:, None]
    own[~own.any(axis=1), -1] = True  # among many equal points the own row may be missing: the last one goes
    return distances[~own].reshape(n, k), rows[~own].reshape(n, k)


def gaussian_graph(points: Points, n_neighbors: int) -> csr_array:
    """Weights exp(-d^2 / s^2) of the edges to each point's nearest others, in both directions.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    n_neighbors : int

    Returns
    -------
    csr_array, shape (n, n)
        Symmetric; s is the root mean square of all the edges' lengths, so that scaling the cloud changes
        nothing. Where all points coincide every weight is 1.
    """
    distances, rows = nearest_others(points, n_neighbors)
    squared = np.square(distances / (distances.max(initial=0.0) or 1.0)).ravel()
    weights = np.exp(-squared / (squared.mean() if squared.any() else 1.0))
    n, k = rows.shape
    graph = csr_array((weights, (np.repeat(np.arange(n), k), rows.ravel())), shape=(n, n))
    return csr_array(graph.maximum(graph.T))


def high_pass(graph: csr_array, points: Points) -> Points:
    """Each point's offset from the weighted mean of its neighbours, shape (n, 3): (I - D^-1 W) X.

    The Haar-like high-pass graph filter of Chen and others, Fast resampling of three-dimensional point clouds
    via graphs, IEEE TSP 66(3), 2018. A point without neighbours has none.
    """
    degrees = np.maximum(graph.sum(axis=1), np.finfo(float).tiny)
    centred = points - points.mean(axis=0)
    return centred - (graph @ centred) / degrees[:, None]


def high_pass_energy(points: Points, n_neighbors: int) -> Vector:
    """Squared length of each point's `high_pass` offset on its `gaussian_graph`, shape (n,), of mean 1.

    Where no point differs from its neighbours' mean, all are 0.
    """
    scaled = normalize(points)[0]
    energy = np.square(high_pass(gaussian_graph(scaled, n_neighbors), scaled)).sum(axis=1)
    return energy / (energy.mean() or 1.0)
