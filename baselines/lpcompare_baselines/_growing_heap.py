"""A binary heap of rows whose keys only grow, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from lpcompare.types import Indices, Vector


@njit(cache=True)
def heap_of(keys: Vector) -> tuple[Indices, Indices]:
    """A heap of all rows, the least key first (of equals the last row), and where each row is in it."""
    heap = np.arange(len(keys))
    places = np.arange(len(keys))
    for place in range(len(keys) // 2 - 1, -1, -1):
        sink(heap, places, keys, place, len(keys))
    return heap, places


@njit(cache=True)
def sink(heap: Indices, places: Indices, keys: Vector, place: Any, size: int) -> None:
    """Move the row at a place down to where its key belongs, after the key has grown."""
    row = heap[place]
    while 2 * place + 1 < size:
        child = 2 * place + 1
        if child + 1 < size and _before(keys, heap[child + 1], heap[child]):
            child += 1
        if not _before(keys, heap[child], row):
            break
        heap[place] = heap[child]
        places[heap[place]] = place
        place = child
    heap[place] = row
    places[row] = place


@njit(cache=True)
def pop(heap: Indices, places: Indices, keys: Vector, size: int) -> int:
    """Take the first row out of the first ``size`` places; it moves to the last of them."""
    first, last = heap[0], heap[size - 1]
    heap[0], heap[size - 1] = last, first
    places[last], places[first] = 0, size - 1
    sink(heap, places, keys, 0, size - 1)
    return first


@njit(cache=True)
def _before(keys: Vector, row: Any, other: Any) -> Any:
    return keys[row] < keys[other] or (keys[row] == keys[other] and row > other)
