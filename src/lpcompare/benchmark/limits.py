"""What a child process puts on itself: a memory limit, an end with its parent, and its own peak memory."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from pathlib import Path

CANNOT_WRITE = 74
"""Exit code of a child process that could not hand over its result, for example because the disk is full."""

_PR_SET_PDEATHSIG = 1
_STATUS = Path("/proc/self/status")


def limit_memory(limit_mib: int) -> None:
    """Let allocations beyond ``limit_mib`` fail.

    RLIMIT_DATA counts what is allocated; RLIMIT_AS would count address space, which thread arenas and
    libraries reserve by the gigabyte without using it.
    """
    if sys.platform == "win32":
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = limit_mib * 2**20
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def die_with_parent(parent: int) -> None:
    """Have this process killed when the harness dies, so that a hanging case does not outlive ``kill -9``."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)


def peak_memory_mib() -> float | None:
    """Largest resident memory of this process so far, in MiB.

    Read from /proc where it exists: there ru_maxrss also counts what the parent held before exec.
    """
    if _STATUS.exists():
        for line in _STATUS.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    if sys.platform == "win32":
        return None
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 1024
