"""Writing to disk: a file whole or not at all, and a failure as one sentence."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lpcompare.errors import InputError

ANOTHER_FOLDER = "make room, or name another folder with --out"
CONTINUE = "make room and continue with --resume"
_AGAIN = "make room, or choose a place that can be written, and try again"


@contextmanager
def writing(path: Path, remedy: str = _AGAIN) -> Iterator[None]:
    """Say of a failure to write which file or folder it was, why, and what to do; raises `InputError`."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path} cannot be written ({error.strerror or error}); {remedy}.") from error


@contextmanager
def whole_file(path: Path, remedy: str = _AGAIN) -> Iterator[Path]:
    """The file to write instead of ``path``: it takes that place at the end, or is removed after a failure.

    It is new, in the same folder and under a name that nobody can know before; a file that is replaced keeps
    its mode.

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
    part = target.with_name(f".{secrets.token_hex(8)}{target.suffix[:20]}")
    with writing(path, remedy):
        target.parent.mkdir(parents=True, exist_ok=True)
        mode = 0o600 if target.exists() else 0o666
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
        try:
            yield part
            if target.exists():
                shutil.copymode(target, part)
            os.replace(part, target)
        finally:
            part.unlink(missing_ok=True)


def replace_text(path: Path, text: str, remedy: str = _AGAIN) -> None:
    """Write a text file whole, flushed to the disk, or leave it as it was; raises `InputError`."""
    with whole_file(path, remedy) as part, part.open("w", encoding="utf-8", newline="") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
