"""Inputs as files of this machine: patterns are listed, and what is behind a URL is copied once (fsspec)."""

from __future__ import annotations

import errno
import glob
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import unquote, urlsplit

from lpcompare.errors import InputError, Unavailable
from lpcompare.files import CONTINUE, whole_file

_FOLDER = {errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS}
"""What is wrong with the folder of the copies, not with the URL."""


def local_files(inputs: str | Path | Iterable[str | Path], folder: Path) -> list[Path]:
    """The files behind paths, patterns and URLs; ``folder`` is for what is fetched.

    Raises
    ------
    InputError
        There is no input, a file does not exist, or a URL cannot be fetched.
    Unavailable
        A URL is named and fsspec is not installed.
    """
    words = [inputs] if isinstance(inputs, (str, Path)) else list(inputs)
    files = [path for word in words for path in _files(str(word), folder)]
    if not files:
        raise InputError("There is no input; name at least one file.")
    return files


def is_url(word: str) -> bool:
    """Whether a word names a file elsewhere."""
    return "://" in word


def matches(word: str) -> list[str]:
    """The files of a pattern that the shell has left alone, sorted; any other word as it is."""
    if Path(word).exists() or not glob.has_magic(word):
        return [word]
    if found := sorted(glob.glob(word)):
        return found
    raise InputError(f"No file matches {word!r}.")


def _files(word: str, folder: Path) -> list[Path]:
    if is_url(word):
        return [_fetched(word, folder)]
    found = matches(word)
    for path in found:
        if not Path(path).is_file():
            raise InputError(f"{path} is no file; name files that exist.")
    return [Path(path).absolute() for path in found]


def _fetched(url: str, folder: Path) -> Path:
    try:
        import fsspec
    except ImportError as error:
        raise Unavailable(
            "fsspec is not installed, and URLs need it. Install it with: pip install 'lpcompare[large]'."
        ) from error
    target = folder / Path(unquote(urlsplit(url).path)).name
    if target.exists():
        return target
    try:
        with whole_file(target, CONTINUE) as part:
            files, place = fsspec.url_to_fs(url)
            try:
                files.get_file(place, str(part))
            except OSError as error:
                if error.errno in _FOLDER:
                    raise
                raise ValueError(str(error) or type(error).__name__) from error
    except (ValueError, ImportError) as error:
        raise InputError(f"{url} cannot be fetched ({error or type(error).__name__}).") from error
    return target
