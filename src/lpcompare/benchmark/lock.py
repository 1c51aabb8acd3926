"""One writer per run folder, by the operating system's lock: it ends with its process, however that ends."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lpcompare.errors import InputError
from lpcompare.files import ANOTHER_FOLDER, writing


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """Keep other processes from writing the run of a folder meanwhile.

    Parameters
    ----------
    folder : Path
        Created if need be.

    Raises
    ------
    InputError
        The folder cannot be written, or another process is writing it.
    """
    path = folder / ".lock"
    with writing(folder, ANOTHER_FOLDER):
        folder.mkdir(parents=True, exist_ok=True)
        file = path.open("ab")
    with file:
        if not _taken(file.fileno(), path):
            raise InputError(
                f"{folder} is being written by another lpcompare; "
                "wait until it has ended, or name another folder with --out."
            )
        try:
            yield
        finally:
            with suppress(OSError):  # Windows lets nobody remove an open file; it does no harm
                path.unlink()


def _taken(descriptor: int, path: Path) -> bool:
    """Lock the file, unless another process holds it or has removed it since it was opened."""
    try:
        _lock(descriptor)
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except (BlockingIOError, PermissionError, FileNotFoundError):
        return False


def _lock(descriptor: int) -> None:
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
