"""k nearest neighbours: a compiled k-d tree, which also gives an order in which near points lie together."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.threads import Progress, for_blocks, map_in_threads
from lpcompare.types import Indices, Points

Rows = NDArray[np.int32]
Block = Callable[[slice, NDArray[np.float64], Rows], None]

_TOP_LEVELS = 3


class Neighbors:
    """A k-d tree over a cloud.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The cloud, finite, in model units.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        As given.
    order : ndarray of int32, shape (n,)
        Every row once, near rows together.
    sorted_points : ndarray, shape (n, 3)
        ``points[order]``, whose rows are the places of the tree.
    leaves : ndarray of int64, shape (l + 1,)
        First place of each leaf, and n.
    arrays : tuple of ndarray
        What the kernels take: ``sorted_points``, the places of each node, and its box.
    """

    def __init__(self, points: Points) -> None:
        from lpcompare.geometry.kernels import LEAF, build_tree

        n_points = len(points)
        n_levels = 1 + max(0, int(np.ceil(np.log2(max(n_points, 1) / LEAF))))
        starts = np.zeros((2**n_levels - 1, 2), dtype=np.int64)
        starts[0, 1] = n_points
        self.points = points
        self.order = np.arange(n_points, dtype=np.int32)
        self.sorted_points = np.array(points, dtype=np.float64, order="C")
        self.arrays = self.sorted_points, starts, np.empty((len(starts), 6))
        n_top = min(_TOP_LEVELS, n_levels - 1)
        state = self.sorted_points, self.order, *self.arrays[1:]
        build_tree(*state, 0, n_top)
        below = range(2**n_top - 1, 2 ** (n_top + 1) - 1)
        map_in_threads(lambda node: build_tree(*state, node, n_levels - n_top), below)
        self.leaves = np.append(starts[len(starts) // 2 :, 0], n_points)

    def in_rows(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (n, ...) by place of the tree as values by row of the cloud."""
        result = np.empty_like(values)
        result[self.order] = values
        return result

    def query(self, queries: Points, n_neighbors: int) -> tuple[NDArray[np.float64], Indices]:
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
        distances, indices = np.empty((len(queries), k)), np.empty((len(queries), k), dtype=np.intp)

        def keep(block: slice, squares: NDArray[np.float64], places: Rows) -> None:
            np.sqrt(squares, out=distances[block])
            indices[block] = self.order[places]

        self.each(queries, k, keep)
        return distances, indices

    def each(self, queries: Points, n_neighbors: int, work: Block, progress: Progress | None = None) -> None:
        """Call ``work`` with the neighbours of one block of queries after the other, from several threads.

        Parameters
        ----------
        queries : ndarray, shape (q, 3)
        n_neighbors : int
            Neighbours per query; cut to the size of the cloud.
        work : callable
            Called with the block as a slice, the squared distances (b, k), and the places (b, k) in
            ``sorted_points``. Blocks do not depend on the number of threads.
        progress : callable, optional
            Called with (blocks done, blocks).
        """
        from lpcompare.geometry.kernels import query_block

        k = min(n_neighbors, len(self.points))
        queries = np.ascontiguousarray(queries, dtype=np.float64)

        def find(block: slice) -> None:
            squares = np.empty((block.stop - block.start, k))
            places = np.empty(squares.shape, dtype=np.int32)
            query_block(queries[block], *self.arrays, squares, places)
            work(block, squares, places)

        for_blocks(len(queries), find, progress)
