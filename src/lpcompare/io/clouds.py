"""Point clouds as .npz files: the inputs that are handed to child processes, and what is kept of results."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError
from lpcompare.files import CONTINUE, whole_file
from lpcompare.types import PointCloud

_OWN = ("points", "normals", "colors", "faces")
_ATTRIBUTE = "attribute:"


def save_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write an .npz whole or not at all; raises `InputError` where it cannot be written."""
    with whole_file(path, CONTINUE) as part, part.open("wb") as file:
        np.savez(file, **arrays)  # pyright: ignore[reportArgumentType]


def load_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Every array of an .npz.

    Raises
    ------
    InputError
        The file is missing, truncated or not an .npz.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            return dict(file)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(
            f"{path} is not a readable .npz file ({error}); the run must be made again."
        ) from error


def save_cloud(path: Path, cloud: PointCloud) -> None:
    """Write a cloud with everything that it carries."""
    save_arrays(path, _arrays(cloud))


def load_cloud(path: Path) -> PointCloud:
    """Read what `save_cloud` wrote; raises `InputError` as `load_arrays` does."""
    arrays = load_arrays(path)
    attributes = {k.removeprefix(_ATTRIBUTE): v for k, v in arrays.items() if k.startswith(_ATTRIBUTE)}
    return PointCloud(**{k: arrays[k] for k in _OWN if k in arrays}, attributes=attributes, name=path.stem)


def digest(cloud: PointCloud) -> str:
    """SHA-256 of all that a method can see of a cloud."""
    state = hashlib.sha256()
    for name, array in sorted(_arrays(cloud).items()):
        state.update(f"{name} {array.dtype} {array.shape}".encode())
        state.update(np.ascontiguousarray(array).data)
    return state.hexdigest()


def _arrays(cloud: PointCloud) -> dict[str, NDArray[Any]]:
    own = {name: getattr(cloud, name) for name in _OWN if getattr(cloud, name) is not None}
    return own | {_ATTRIBUTE + name: np.asarray(a) for name, a in cloud.attributes.items()}
