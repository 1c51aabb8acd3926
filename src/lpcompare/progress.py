"""Seconds per stage, and what a callback is told of each stage."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

Callback = Callable[[str, int, int], None]


class StageClock:
    """One running stage at a time.

    Parameters
    ----------
    callback : callable, optional
        Called with (stage, done, total).
    """

    def __init__(self, callback: Callback | None) -> None:
        self._callback = callback
        self._timings: dict[str, float] = {}
        self._stage, self._began = "", perf_counter()

    def stage(self, name: str) -> Callable[[int, int], None]:
        """End the running stage, begin the next, and return what reports its progress."""
        self.stop()
        self._stage, self._began = name, perf_counter()
        return lambda done, total: self._callback(name, done, total) if self._callback else None

    def stop(self) -> dict[str, float]:
        """Seconds of every stage that has ended."""
        if self._stage:
            self._timings[self._stage] = perf_counter() - self._began
            self._stage = ""
        return dict(self._timings)
