"""The clock, and a fixed piece of work that tells how fast the machine is at the moment."""

from __future__ import annotations

import gc
from collections.abc import Callable
from time import perf_counter
from typing import TypeVar

import numpy as np
from scipy.spatial import KDTree

T = TypeVar("T")

_REFERENCE_POINTS, _REFERENCE_ROUNDS = 4000, 3


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """The result of a call, and its seconds on the wall clock."""
    gc.collect()
    start = perf_counter()
    result = call()
    return result, perf_counter() - start


def reference_seconds() -> float:
    """Seconds of a fixed k-d tree search and matrix product on one thread, the best of three.

    The work never changes, so its time is a property of the machine and of what else runs on it.
    """
    points = np.random.default_rng(0).random((_REFERENCE_POINTS, 3))
    return min(timed(lambda: _reference_work(points))[1] for _ in range(_REFERENCE_ROUNDS))


def _reference_work(points: np.ndarray) -> None:
    _, indices = KDTree(points).query(points, k=8, workers=1)
    gathered = points[indices]
    np.linalg.eigh(np.einsum("qki,qkj->qij", gathered, gathered))
