"""A binary heap whose entries know their place, so that a key can change (compiled)."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit("void(i8, i8[::1], i8, i8[::1], f8[::1])", cache=True)
def settle(at, heap, size, place, keys):
    """Move the entry at one position of a heap up or down to where it belongs.

    Parameters
    ----------
    at : int
        The position whose key is new; every other entry of the heap is in order.
    heap : ndarray of int
        The rows in the heap, the one of smallest key first, the lowest row where keys are equal.
    size : int
        Entries of ``heap`` that count.
    place : ndarray of int, shape (n,)
        Position of each row in the heap.
    keys : ndarray, shape (n,)
    """
    row = heap[at]
    while at and (keys[row], row) < (keys[heap[(at - 1) // 2]], heap[(at - 1) // 2]):
        heap[at] = heap[(at - 1) // 2]
        place[heap[at]] = at
        at = (at - 1) // 2
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and (keys[heap[child + 1]], heap[child + 1]) < (keys[heap[child]], heap[child]):
            child += 1
        if (keys[row], row) < (keys[heap[child]], heap[child]):
            break
        heap[at] = heap[child]
        place[heap[at]] = at
        at = child
    heap[at] = row
    place[row] = at


@njit("Tuple((i8[::1], i8[::1]))(f8[::1])", cache=True)
def heap_of(keys):
    """A heap of all rows, and the position of each row in it."""
    heap, place = np.arange(len(keys)), np.arange(len(keys))
    for at in range(len(keys)):
        settle(at, heap, at + 1, place, keys)
    return heap, place


@njit("i8(i8[::1], i8, i8[::1], f8[::1])", cache=True)
def pop(heap, size, place, keys):
    """Take the row of smallest key out of a heap of ``size`` entries; its place becomes -1."""
    row = heap[0]
    place[row] = -1
    if size > 1:
        heap[0] = heap[size - 1]
        settle(0, heap, size - 1, place, keys)
    return row
