"""A model's file: checked against its checksum wherever it comes from, and kept only when it is right."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from lpcompare.errors import ModelDataError

_SECONDS = 30.0


def fetch(url: str, checksum: str, folder: Path) -> Path:
    """The file of ``url`` in ``folder``; downloaded when it is not there or is not the right one.

    Parameters
    ----------
    url : str
    checksum : str
        "sha256:..." or "git:...", the id of a git blob.
    folder : path
        The cache; created when it is missing.

    Raises
    ------
    ModelDataError
        No connection, an interrupted or a wrong download; nothing of it is kept.
    """
    path = folder / url.rpartition("/")[2]
    if path.is_file() and file_checksum(path, checksum) == checksum:
        return path
    part = path.with_suffix(f".{os.getpid()}.part")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _download(url, part)
        check_file(part, checksum, url)
        os.replace(part, path)
    except ModelDataError:
        raise
    except OSError as error:
        raise ModelDataError(_unwritable(folder, error)) from error
    finally:
        part.unlink(missing_ok=True)
    return path


def check_file(path: Path, checksum: str, origin: str) -> None:
    """Raise a `ModelDataError` that names ``origin`` unless the file has the checksum."""
    found = file_checksum(path, checksum)
    if found != checksum:
        raise ModelDataError(
            f"{origin} is not the file that the catalogue describes "
            f"({path.stat().st_size} bytes with checksum {found}, expected {checksum}); "
            "it was not kept. Try again, or set LPCOMPARE_MODELS to a folder that holds the right file."
        )


def file_checksum(path: Path, like: str) -> str:
    """Checksum of a file in the form of ``like``: "sha256:..." or, for a git blob, "git:..."."""
    content = path.read_bytes()
    if like.startswith("git:"):
        header = f"blob {len(content)}\0".encode()
        return "git:" + hashlib.sha1(header + content, usedforsecurity=False).hexdigest()
    return "sha256:" + hashlib.sha256(content).hexdigest()


def _download(url: str, path: Path) -> None:
    """Download with pooch; what can go wrong on the way is one sentence."""
    import pooch
    import requests

    try:
        pooch.HTTPDownloader(timeout=_SECONDS)(url, str(path), None)
    except requests.exceptions.HTTPError as error:
        raise ModelDataError(f"{url} could not be downloaded: the server answered {error}.") from error
    except requests.exceptions.RequestException as error:
        raise ModelDataError(
            f"{url} could not be downloaded ({type(error).__name__}); check the network, "
            "or set LPCOMPARE_MODELS to a folder that holds the file."
        ) from error


def _unwritable(folder: Path, error: OSError) -> str:
    return f"The cache folder {folder} cannot be written ({error.strerror or error}); make room or allow it."
