"""Child processes with limits: started clean, watched with all that they start, ended with all of it.

Between this process and a child stands its guard (`lpcompare.guard`). When this process dies, however it
dies, the guard ends the child and every process that the child has left anywhere.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from lpcompare import guard as _guard

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
    """Runs child processes; all that are alive can be ended at once, from any thread."""

    def __init__(self) -> None:
        self._guards: set[subprocess.Popen[bytes]] = set()
        self._stopped = False

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
        self._guards.add(guard)
        try:
            with guard:  # leaving closes its standard input: the guard ends everything, then itself
                text = guard.stdout.read() if guard.stdout and not self._stopped else b""
        finally:
            self._guards.discard(guard)
        if self._stopped:
            raise Stopped
        if guard.returncode != 0 or not text:
            _end_marked(mark)
            return Ending(None, "guard", "", "")
        return Ending(**json.loads(text))

    def stop(self) -> None:
        """End every child; those who wait for one meet `Stopped`."""
        self._stopped = True
        for guard in tuple(self._guards):
            if guard.stdin:
                guard.stdin.close()


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


def _end_marked(mark: str) -> None:
    """End the processes of a child whose guard was killed: they carry its mark in their environment."""
    import psutil

    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if process.environ().get(_MARK) == mark:
                process.kill()
