"""The clock, a fixed piece of work that tells how fast the machine is, and what other programs take of it."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import TypeVar

import numpy as np
import psutil
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


class OtherPrograms:
    """What other programs take of the processors from now on."""

    def __init__(self) -> None:
        self._began = _used()

    def load(self) -> float:
        """Processors that they held on average since."""
        wall, busy, own = (now - then for now, then in zip(_used(), self._began, strict=True))
        return max(busy - own, 0.0) / wall


def _used() -> tuple[float, float, float]:
    """Seconds on the wall clock, of all processors in use, and of this process with its children."""
    times = psutil.cpu_times()._asdict()
    # time of a guest is counted as the user's too
    idle = sum(times.get(name, 0.0) for name in ("idle", "iowait", "guest", "guest_nice"))
    return perf_counter(), sum(times.values()) - idle, sum(os.times()[:4])


def _reference_work(points: np.ndarray) -> None:
    _, indices = KDTree(points).query(points, k=8, workers=1)
    gathered = points[indices]
    np.linalg.eigh(np.einsum("qki,qkj->qij", gathered, gathered))


def peak_memory_mib() -> float | None:
    """Largest resident memory of this process so far, in MiB.

    Read from /proc where it exists: there ru_maxrss also counts what the parent held before exec.
    """
    status = Path("/proc/self/status")
    if status.exists():
        (line,) = [line for line in status.read_text().splitlines() if line.startswith("VmHWM:")]
        return int(line.split()[1]) / 1024
    if sys.platform == "win32":
        return None
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 1024
