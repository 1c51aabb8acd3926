"""Writing to disk: a file whole or not at all, and a failure as one sentence."""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import FrameType

from lpcompare.errors import InputError

try:
    import fcntl
except ImportError:  # Windows, where parts of killed processes stay
    fcntl = None  # type: ignore[assignment]

ANOTHER_FOLDER = "make room, or name another folder with --out"
ANOTHER_TMPDIR = "make room, or name another folder for temporary files with the variable TMPDIR"
CONTINUE = "make room and continue with --resume"
_AGAIN = "make room, or choose a place that can be written, and try again"
_PART, _DIGITS = ".lpcompare-", 16
_NO_REASON = "the disk may be full"
_ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def writing(path: Path, remedy: str = _AGAIN) -> Iterator[None]:
    """Say of a failure to write which file or folder it was, why, and what to do; raises `InputError`."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror or _NO_REASON}); {remedy}.") from error


def state_of(path: Path) -> tuple[int, int, int]:
    """What changes when a file does: its place on the disk, its size and its time."""
    facts = path.stat()
    return facts.st_ino, facts.st_size, facts.st_mtime_ns


def check_unchanged(path: Path, state: tuple[int, int, int]) -> None:
    """Raise an `InputError` where a file is not as it was when its `state_of` was taken."""
    if state_of(path) != state:
        raise InputError(
            f"{path} was changed while it was read; wait until the program that writes it has ended."
        )


@contextmanager
def whole_file(path: Path, remedy: str = _AGAIN) -> Iterator[Path]:
    """The file to write instead of ``path``: it takes that place at the end, or is removed after a failure.

    It is new, in the same folder and under a name that nobody can know before; a file that is replaced keeps
    its mode. SIGTERM and SIGHUP remove it before they end the process. What a process left that was killed is
    removed when the next one writes into the folder.

    Parameters
    ----------
    path : Path
        Left as it was until the end; its folder is created if need be. Of a link, the file behind it.
    remedy : str
        What a person can do about a failure.

    Raises
    ------
    InputError
        It cannot be written.
    """
    target = Path(os.path.realpath(path))
    with _signals_as_exceptions(), writing(path, remedy):
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_left_parts(target.parent)
        mode = 0o600 if target.exists() else 0o666
        part, lock = _new_part(target, mode)
        try:
            yield part
            if target.exists():
                shutil.copymode(target, part)
            os.replace(part, target)
        finally:
            part.unlink(missing_ok=True)
            os.close(lock)


def _new_part(target: Path, mode: int) -> tuple[Path, int]:
    """A new file beside ``target``, and its descriptor, which is locked as long as this process lives."""
    while True:
        part = target.with_name(f"{_PART}{secrets.token_hex(_DIGITS // 2)}{target.suffix[:20]}")
        file = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
        if fcntl is None:
            return part, file
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_EX)
        if os.fstat(file).st_nlink:
            return part, file
        os.close(file)  # another process took it for a part that was left


@cache
def _remove_left_parts(folder: Path) -> None:
    """Remove the parts of processes that were killed: nobody holds their locks."""
    if fcntl is None:
        return
    for part in folder.glob(f"{_PART}{_DIGITS * '[0-9a-f]'}*"):
        with suppress(OSError):
            file = os.open(part, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                part.unlink()
            finally:
                os.close(file)


class _Ended(BaseException):
    """A signal that ends the process."""

    def __init__(self, number: int) -> None:
        self.number = number


def _raise_ended(number: int, _: FrameType | None) -> None:
    raise _Ended(number)


@contextmanager
def _signals_as_exceptions() -> Iterator[None]:
    """Let signals that would end the process at once unwind the block first."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    plain = [number for number in _ENDING if signal.getsignal(number) is signal.SIG_DFL]
    for number in plain:
        signal.signal(number, _raise_ended)
    try:
        yield
    except _Ended as ended:
        if ended.number not in plain:
            raise
        signal.signal(ended.number, signal.SIG_DFL)
        os.kill(os.getpid(), ended.number)
    finally:
        for number in plain:
            signal.signal(number, signal.SIG_DFL)


def replace_text(path: Path, text: str, remedy: str = _AGAIN) -> None:
    """Write a text file whole, flushed to the disk, or leave it as it was; raises `InputError`."""
    with whole_file(path, remedy) as part, part.open("w", encoding="utf-8", newline="") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
