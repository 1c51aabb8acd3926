"""A binary heap whose entries know their place, so that a key can change (compiled)."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def _before(row, other, keys, last_first):
    if keys[row] != keys[other]:
        return keys[row] < keys[other]
    return (row > other) == last_first


@njit(cache=True)
def settle(at, heap, size, place, keys, last_first=False):
    """Move the entry at one position of a heap up or down to where it belongs.

    Parameters
    ----------
    at : int
        The position whose key is new; every other entry of the heap is in order.
    heap : ndarray of int
        The rows in the heap, the one of smallest key first.
    size : int
        Entries of ``heap`` that count.
    place : ndarray of int, shape (n,)
        Position of each row in the heap.
    keys : ndarray, shape (n,)
    last_first : bool, optional
        Which of equal keys comes first: the highest row, by default the lowest.
    """
    row = heap[at]
    while at and _before(row, heap[(at - 1) // 2], keys, last_first):
        heap[at] = heap[(at - 1) // 2]
        place[heap[at]] = at
        at = (at - 1) // 2
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and _before(heap[child + 1], heap[child], keys, last_first):
            child += 1
        if _before(row, heap[child], keys, last_first):
            break
        heap[at] = heap[child]
        place[heap[at]] = at
        at = child
    heap[at] = row
    place[row] = at


@njit(cache=True)
def heap_of(keys, last_first=False):
    """A heap of all rows, and the position of each row in it; equal keys as in `settle`."""
    heap, place = np.arange(len(keys)), np.arange(len(keys))
    for at in range(len(keys)):
        settle(at, heap, at + 1, place, keys, last_first)
    return heap, place


@njit(cache=True)
def pop(heap, size, place, keys, last_first=False):
    """Take the row of smallest key out of a heap of ``size`` entries; its place becomes -1."""
    row = heap[0]
    place[row] = -1
    if size > 1:
        heap[0] = heap[size - 1]
        settle(0, heap, size - 1, place, keys, last_first)
    return row
