"""How many threads lpcompare may use."""

from __future__ import annotations

import os


def thread_count() -> int:
    """Threads to use: ``LPCOMPARE_THREADS`` if it is set, else the processors this process may run on."""
    wanted = os.environ.get("LPCOMPARE_THREADS", "")
    if wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
