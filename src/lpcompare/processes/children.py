"""Child processes with limits: started clean, watched with all that they start, ended with all of it.

Between this process and a child stands its guard (`lpcompare.processes.guard`). When this process dies, however it
dies, the guard ends the child and every process that the child has left anywhere.

A child is a program, or, after `Children.prepare`, a call of a module that one process has imported for all
(`lpcompare.processes.nursery`).
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import IO, BinaryIO

from lpcompare.processes import guard as _guard
from lpcompare.processes import nursery as _nursery

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
_PYTHON_KEPT = (
    "PYTHONHOME",
    "PYTHONUTF8",
    "PYTHONDONTWRITEBYTECODE",
    "PYTHONPYCACHEPREFIX",
    "PYTHONUSERBASE",
)
_MARK = "LPCOMPARE_CHILD"
_NURSERY_S, _LOOK_S = 0.5, 0.1
_PREFIX, _NEW, _NEW_SECONDS = "lpcompare-", "lpcompare-new-", 600


class Stopped(Exception):  # noqa: N818 - an order, not a fault
    """`Children.stop` was called while a child was running."""


@dataclass(frozen=True)
class Ending:
    """How a child process ended.

    Attributes
    ----------
    code : int or None
        Its exit code, or minus the signal that ended it; None when a limit did.
    limit : str
        ``time`` or ``memory`` when that limit ended it, ``guard`` when its guard was killed, else empty.
    answer : str
        The last 4 MiB of what it wrote to the stream of `answer_stream`, or to standard output.
    errors : str
        The last 64 KiB of its standard error.
    """

    code: int | None
    limit: str
    answer: str
    errors: str

    def last_lines(self, n_lines: int = 3, n_characters: int = 300) -> str:
        """The end of its standard error in one line."""
        lines = [line.strip() for line in self.errors.splitlines() if line.strip()]
        return " | ".join(lines[-n_lines:])[-n_characters:]


class Children:
    """Runs child processes; all that are alive can be ended at once, from any thread.

    As a context manager it ends the process of `prepare` as well.
    """

    def __init__(self) -> None:
        self._ends: set[Callable[[], object]] = set()
        self._stopped = False
        self._nursery: Nursery | None = None

    def __enter__(self) -> Children:
        return self

    def __exit__(self, *_: object) -> None:
        if self._nursery:
            self._nursery.close()

    def prepare(self, module: str, *arguments: object, threads: int | None = None) -> None:
        """Let one process import a module and call its ``prepare`` before the first child of `call`.

        Parameters
        ----------
        module : str
            Its functions ``prepare(*arguments)`` and ``main(*arguments)`` are called. Without the means to
            fork a process that is prepared (all systems but Linux), each child is a program of its own.
        *arguments
            JSON-ready.
        threads : int, optional
            Threads that the libraries of the children may use.
        """
        if sys.platform == "linux":
            self._nursery = Nursery(module, arguments, threads)

    def start(self) -> None:
        """Start the process of `prepare` now, and not when the first child is wanted; returns at once."""
        if self._nursery:
            self._nursery.start()

    def call(
        self,
        module: str,
        *arguments: str,
        folder: Path,
        time_limit_s: float,
        memory_limit_mib: int,
        threads: int | None = None,
    ) -> Ending:
        """Call ``main(*arguments)`` of a module in a child, forked if it was prepared; otherwise as `run`."""
        limits = {"time_limit_s": time_limit_s, "memory_limit_mib": memory_limit_mib}
        if self._nursery is None:
            return self.run(python("-m", module, *arguments), folder, threads=threads, **limits)
        order = {"arguments": arguments, "folder": str(folder), **limits}
        return self._ended(*self._nursery.guard(order))

    def run(
        self,
        command: Sequence[str],
        folder: Path,
        *,
        time_limit_s: float,
        memory_limit_mib: int,
        threads: int | None = None,
    ) -> Ending:
        """Run a program to its end, and end what it leaves behind.

        Parameters
        ----------
        command : sequence of str
            The program and its arguments; `python` is the beginning of one in Python.
        folder : Path
            Its current folder, and its place for temporary files.
        time_limit_s : float
            Seconds on the wall clock after which it is killed.
        memory_limit_mib : int
            Memory of it and of all that it starts, shared memory counted once. Allocations of one process
            beyond it fail; the whole is looked at five times a second and killed.
        threads : int, optional
            Threads that its libraries may use.

        Returns
        -------
        Ending

        Raises
        ------
        Stopped
            `stop` was called meanwhile.
        """
        mark = uuid.uuid4().hex
        order = {
            "command": list(command),
            "folder": str(folder),
            "time_limit_s": time_limit_s,
            "memory_limit_mib": memory_limit_mib,
        }
        guard = subprocess.Popen(
            [sys.executable, "-P", _guard.__file__, json.dumps(order)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=clean_environment(threads) | {_MARK: mark, "TMPDIR": str(folder)},
            start_new_session=True,
        )
        assert guard.stdin
        assert guard.stdout
        with guard:  # leaving closes its standard input: the guard ends everything, then itself
            return self._ended(guard.stdout, guard.stdin.close, lambda: _end_marked(mark))

    def _ended(self, text: IO[bytes], end: Callable[[], object], end_left: Callable[[], object]) -> Ending:
        """Read how a child ended; a guard that says nothing was killed."""
        self._ends.add(end)
        try:
            told = b"" if self._stopped else text.read()
        finally:
            self._ends.discard(end)
            end()
            text.close()
        if self._stopped:
            raise Stopped
        if not told:
            end_left()
            return Ending(None, "guard", "", "")
        return Ending(**json.loads(told))

    def stop(self) -> None:
        """End every child; those who wait for one meet `Stopped`."""
        self._stopped = True
        for end in tuple(self._ends):
            end()


class Nursery:
    """The process that children are forked from (`lpcompare.processes.nursery`), started when the first one is wanted.

    Where it was killed, another one is started.
    """

    def __init__(self, module: str, arguments: Sequence[object], threads: int | None) -> None:
        self._words, self._threads = [module, json.dumps(arguments)], threads
        self._lock = Lock()
        self._guards: set[int] = set()
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start it, unless it is there."""
        with self._lock:
            if self._process is None:
                self._start()

    def _start(self) -> None:
        self._orders, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._mark = uuid.uuid4().hex
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", _nursery.__file__, str(theirs.fileno()), *self._words],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=clean_environment(self._threads) | {_MARK: self._mark},
                start_new_session=True,
            )

    def guard(self, order: dict[str, object]) -> tuple[IO[bytes], Callable[[], object], Callable[[], object]]:
        """Have a child forked; returns its guard's words, what ends the guard, and what ends the rest."""
        ours, theirs = socket.socketpair()
        with theirs, self._lock:
            message = [json.dumps(order).encode()]
            if self._process is None:
                self._start()
            try:
                socket.send_fds(self._orders, message, [theirs.fileno()])
            except OSError:  # it was killed
                self.close()
                self._start()
                socket.send_fds(self._orders, message, [theirs.fileno()])
        text = ours.makefile("rb")
        pid = int(text.readline() or 0)
        self._guards.add(pid)

        def end() -> None:
            self._guards.discard(pid)
            with suppress(OSError):
                ours.shutdown(socket.SHUT_WR)
            ours.close()  # the file of it stays open until it is read

        return text, end, self._end_left

    def _end_left(self) -> None:
        """End what a killed guard has left, where the process that would do so was killed too."""
        with suppress(subprocess.TimeoutExpired):
            if self._process:
                self._process.wait(_NURSERY_S)
            _end_marked(self._mark, self._guards)

    def close(self) -> None:
        """End it, if it was started; children that are being watched are ended by their guards."""
        if self._process:
            self._orders.close()
            self._process.kill()
            self._process.wait()


def python(*arguments: str) -> list[str]:
    """The command of a Python program that takes nothing from the current folder."""
    return [sys.executable, "-P", *arguments]


def clean_environment(threads: int | None = None) -> dict[str, str]:
    """The environment variables, without what lets Python run code of the current folder or of a variable."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON") or k in _PYTHON_KEPT}
    places = [os.path.abspath(p) for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p]
    kept["PYTHONPATH"] = os.pathsep.join(p for p in places if p != os.getcwd())
    return kept | {"PYTHONHASHSEED": "0"} | ({} if threads is None else thread_environment(threads))


def thread_environment(threads: int) -> dict[str, str]:
    """The environment variables that hold every library to ``threads`` threads."""
    return dict.fromkeys(_THREAD_VARIABLES, str(threads))


def answer_stream() -> BinaryIO:
    """For a child: the stream whose end its parent reads. What else prints from now on goes nowhere."""
    stream = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    return stream


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A new folder that is removed at the end; those that killed processes left are removed first."""
    from filelock import FileLock

    remove_left_folders()
    new = Path(tempfile.mkdtemp(prefix=_NEW))
    folder = new.with_name(_PREFIX + new.name.removeprefix(_NEW))
    with FileLock(new / ".lock"):
        new.rename(folder)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def remove_left_folders() -> None:
    """Remove temporary folders of ours whose process is gone: nobody holds the lock inside."""
    from filelock import FileLock, Timeout

    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        with suppress(OSError, Timeout):
            facts = folder.lstat()
            mine = not hasattr(os, "getuid") or facts.st_uid == os.getuid()
            if folder.name.startswith(_NEW):  # not locked yet, or its process died within a moment
                left = time.time() - facts.st_mtime > _NEW_SECONDS
            else:
                left = (folder / ".lock").exists()
            if mine and left and not folder.is_symlink():
                with FileLock(folder / ".lock", blocking=False):
                    shutil.rmtree(folder, ignore_errors=True)


def _end_marked(mark: str, guards: Collection[int] = ()) -> None:
    """End the processes of children whose guard was killed: they carry its mark in their environment.

    Those below guards that are alive stay. One look can miss a process that is started during it.
    """

    def find() -> list[int]:
        found = _marked(mark, guards)
        if not found:
            time.sleep(_LOOK_S)
            found = _marked(mark, guards)
        return found

    _guard.end_processes(find)


def _marked(mark: str, guards: Collection[int]) -> list[int]:
    import psutil

    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            above = {process.pid, *(parent.pid for parent in process.parents())}
            if process.environ().get(_MARK) == mark and above.isdisjoint(guards):
                found.append(process.pid)
    return found
