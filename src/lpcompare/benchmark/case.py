"""One case in a fresh child process: started, limited, killed as a group, its end told in a sentence."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from threading import TIMEOUT_MAX, Event, Timer
from time import perf_counter
from typing import Any, BinaryIO

from lpcompare.benchmark.limits import CANNOT_WRITE
from lpcompare.errors import InputError
from lpcompare.files import CONTINUE, writing

_THREAD_VARIABLES = (
    "LPCOMPARE_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
)
_TAIL_LINES, _TAIL_CHARACTERS = 3, 300


def thread_environment(threads: int) -> dict[str, str]:
    """The environment variables that hold every library to ``threads`` threads."""
    return dict.fromkeys(_THREAD_VARIABLES, str(threads))


def start_seconds() -> float:
    """Seconds on the wall clock until a process has imported what every case needs, as things are now."""
    modules = "lpcompare.benchmark.worker, lpcompare.benchmark.timing, lpcompare.metrics.comparison"
    began = perf_counter()
    subprocess.run([sys.executable, "-P", "-c", f"import {modules}"], stdin=subprocess.DEVNULL, check=True)
    return perf_counter() - began


class Stopped(Exception):  # noqa: N818 - an order, not a fault
    """The run was stopped while a case was going on; the case has no record."""


class Children:
    """The child processes that are alive, so that all of them can be ended at once."""

    def __init__(self) -> None:
        self._alive: set[subprocess.Popen[bytes]] = set()
        self._stopped = False

    def run(self, request: Mapping[str, Any], folder: Path) -> dict[str, Any]:
        """Run one case in a child process and return the fields of its record that the child decides.

        Parameters
        ----------
        request : mapping
            What `lpcompare.benchmark.worker` is asked to do, with ``time_limit_s`` and ``threads``.
        folder : Path
            An empty folder for the exchange of files with the child.

        Returns
        -------
        dict
            At least ``status`` and ``message``.

        Raises
        ------
        Stopped
            `stop` was called meanwhile.
        InputError
            This process or the child could not write; the case has no record.
        """
        with writing(folder, CONTINUE):
            (folder / "request.json").write_text(json.dumps(request), encoding="utf-8")
        with (folder / "stderr.txt").open("wb") as stderr:
            child = _start(folder, request["threads"], stderr)
            self._alive.add(child)
            try:
                code = _exit_code(child, request["time_limit_s"])
            finally:
                _kill_group(child)
                self._alive.discard(child)
        if self._stopped:
            raise Stopped
        if code == CANNOT_WRITE:
            raise InputError(f"{folder} cannot be written (is the disk full?); {CONTINUE}.")
        return _reply(folder, code, request)

    def stop(self) -> None:
        """End every child; their cases raise `Stopped`."""
        self._stopped = True
        for child in tuple(self._alive):
            _kill_group(child)


def _start(folder: Path, threads: int, stderr: BinaryIO) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "lpcompare.benchmark.worker", str(folder)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=stderr,
        env=os.environ | thread_environment(threads) | {"PYTHONHASHSEED": "0"},
        start_new_session=True,
    )


def _exit_code(child: subprocess.Popen[bytes], limit_s: float) -> int | None:
    """The exit code, or None when the limit ended it; `Popen.wait` with a limit looks only every 50 ms."""
    late = Event()

    def end() -> None:
        late.set()
        _kill_group(child)

    timer = Timer(min(limit_s, TIMEOUT_MAX), end)
    timer.daemon = True
    timer.start()
    try:
        code = child.wait()
    finally:
        timer.cancel()
    return None if late.is_set() else code


def _kill_group(child: subprocess.Popen[bytes]) -> None:
    """End the child and all that it started; only SIGKILL ends a library that loops."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child.pid, signal.SIGKILL) if hasattr(os, "killpg") else child.kill()
    child.wait()


def _reply(folder: Path, code: int | None, request: Mapping[str, Any]) -> dict[str, Any]:
    path = folder / "reply.json"
    reply: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    if reply.pop("finished", False):
        tail = _tail(folder / "stderr.txt") if reply["status"] == "failed" else ""
        return reply | {"message": reply["message"] + tail}
    stage = (folder / "stage").read_text() if (folder / "stage").exists() else "the start"
    if code is None:
        limit = f"{request['time_limit_s']:g}"
        return reply | {"status": "timeout", "message": f"Killed in {stage} after {limit} s, the time limit."}
    sentence = f"{_end(code, request, folder)} in {stage}."
    return reply | {"status": "failed", "message": sentence + _tail(folder / "stderr.txt")}


def _end(code: int, request: Mapping[str, Any], folder: Path) -> str:
    """How a process ended that left no result."""
    if code >= 0:
        return f"The process ended with exit code {code} and no result"
    stderr = (folder / "stderr.txt").read_bytes()
    if b"bad_alloc" in stderr or b"MemoryError" in stderr:
        return f"Out of memory (limit {request['memory_limit_mib']} MiB)"
    if -code == signal.SIGKILL:
        return "The process was killed from outside (SIGKILL; often the system was out of memory)"
    return f"The process crashed with {signal.Signals(-code).name}"


def _tail(stderr: Path) -> str:
    """The last lines that the child wrote."""
    lines = [line.strip() for line in _last_bytes(stderr).splitlines() if line.strip()][-_TAIL_LINES:]
    return f" Last output: {' | '.join(lines)[-_TAIL_CHARACTERS:]}" if lines else ""


def _last_bytes(path: Path, size: int = 4096) -> str:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - size))
        return file.read().decode("utf-8", "replace")
