"""The clock, and a fixed piece of work that tells how fast the machine is at the moment."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter, process_time
from typing import TypeVar

import numpy as np
from scipy.spatial import KDTree

T = TypeVar("T")

_REFERENCE_POINTS, _REFERENCE_ROUNDS = 2000, 3


@dataclass(frozen=True)
class Seconds:
    """How long something took: on the wall clock, and of all processors together."""

    wall: float
    cpu: float


def timed(call: Callable[[], T]) -> tuple[T, Seconds]:
    """The result of a call, and its seconds."""
    gc.collect()
    return _clocked(call)


def _clocked(call: Callable[[], T]) -> tuple[T, Seconds]:
    wall, cpu = perf_counter(), process_time()
    result = call()
    return result, Seconds(perf_counter() - wall, process_time() - cpu)


def reference_seconds() -> Seconds:
    """Seconds of a fixed piece of work on one thread, the median of three: a k-d tree search, small matrices.

    The work never changes, so its time is a property of the machine and of what else runs on it. It is done
    just before and just after the timed call; runtimes of two runs are compared in units of it.
    """
    points = np.random.default_rng(0).random((_REFERENCE_POINTS, 3))
    rounds = [_clocked(lambda: _reference_work(points))[1] for _ in range(_REFERENCE_ROUNDS)]
    return Seconds(median(r.wall for r in rounds), median(r.cpu for r in rounds))


def _reference_work(points: np.ndarray) -> None:
    _, indices = KDTree(points).query(points, k=8, workers=1)
    gathered = points[indices]
    np.linalg.eigh(np.einsum("qki,qkj->qij", gathered, gathered))
