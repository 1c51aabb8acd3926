"""The models by name: catalogue.toml, and the way from an entry to its points."""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from lpcompare.errors import ModelDataError, UnknownName
from lpcompare.io import read
from lpcompare.types import PointCloud

_SECONDS = 30.0
_RETRIES = 1
_WRONG = (
    "{} is not the file that the catalogue describes: its checksum differs. It was not kept. Try again, or set "
    "LPCOMPARE_MODELS to a folder that holds the right file."
)


@dataclass(frozen=True)
class Model:
    """One entry of the catalogue.

    Attributes
    ----------
    title, source, licence, cite : str
        For the report: what it is, who made it, on which terms, whom to name.
    points : int
        How many points it has.
    embedded, url, made_by : str
        Exactly one is set: a file of the pymeshlab wheel, an address, or a function of `synthetic`.
    sha256, git_blob : str
        Checksum of the file; a git blob's id where nothing else is known.
    """

    title: str
    source: str
    points: int
    licence: str
    cite: str
    embedded: str = ""
    url: str = ""
    made_by: str = ""
    sha256: str = ""
    git_blob: str = ""


@cache
def catalogue() -> Mapping[str, Model]:
    """Every model by name."""
    text = files(__package__ or "").joinpath("catalogue.toml").read_text(encoding="utf-8")
    return {name: Model(**entry) for name, entry in tomllib.loads(text).items()}


def model_names() -> tuple[str, ...]:
    """The names of the catalogue, sorted."""
    return tuple(sorted(catalogue()))


def model_summary(name: str) -> str:
    """One line: what the model is, its number of points, and whether it is downloaded.

    Raises
    ------
    UnknownName
    """
    model = _known(name)
    note = ", downloaded once" if model.url else ""
    return f"{model.title} ({model.points:,} points{note})."


def load_model(name_or_path: str) -> PointCloud:
    """A model of the catalogue, or the cloud of any file that can be read.

    Parameters
    ----------
    name_or_path : str
        A name of `model_names`; else a path: something with a file's ending, a folder, or an existing file.
        Files of the catalogue are taken from the folder ``LPCOMPARE_MODELS`` if that is set, else from the
        user's cache, where they are downloaded to when they are first asked for.

    Raises
    ------
    UnknownName
        Neither a name nor a path.
    ModelDataError
        The file of a model could not be fetched or is not the right one.
    InputError
        The file cannot be read.

    Examples
    --------
    >>> len(load_model("bunny"))
    28088
    """
    if name_or_path in catalogue():
        return points_of(name_or_path, catalogue()[name_or_path])
    path = Path(name_or_path)
    if path.suffix or path.name != name_or_path or path.exists():
        return read(path)
    return points_of(name_or_path, _known(name_or_path))


def points_of(name: str, model: Model, cache_folder: Path | None = None) -> PointCloud:
    """The points of an entry; ``cache_folder`` stands in for the user's cache."""
    if model.made_by:
        from lpcompare.models import synthetic

        return getattr(synthetic, model.made_by)()
    return replace(read(_file_of(model, cache_folder)), name=name)


def _known(name: str) -> Model:
    if name not in catalogue():
        raise UnknownName("model", name, catalogue())
    return catalogue()[name]


def _file_of(model: Model, cache_folder: Path | None) -> Path:
    if model.embedded:
        path = _wheel() / model.embedded
    elif folder := os.environ.get("LPCOMPARE_MODELS", ""):
        path = Path(folder) / model.url.rpartition("/")[2]
    else:
        return _fetched(model, cache_folder)
    if not path.is_file():
        raise ModelDataError(f"{path} does not exist; it should hold the model's points.")
    if not _is_right(path, model):
        raise ModelDataError(_WRONG.format(path))
    return path


def _fetched(model: Model, cache_folder: Path | None) -> Path:
    """The file from the cache, or downloaded into it.

    Raises
    ------
    ModelDataError
        No connection, an interrupted or a wrong download; nothing of it is kept.
    """
    import pooch
    import requests

    def download(url: str, file: str, store: pooch.Pooch) -> None:
        pooch.HTTPDownloader(timeout=_SECONDS)(url, file, store)
        if not _is_right(Path(file), model):
            raise ValueError

    pooch.get_logger().setLevel("WARNING")
    name, folder = model.url.rpartition("/")[2], cache_folder or Path(pooch.os_cache("lpcompare"))
    known = {name: f"sha256:{model.sha256}" if model.sha256 else None}
    store = pooch.create(folder, "", registry=known, urls={name: model.url}, retry_if_failed=_RETRIES)
    try:
        if (folder / name).is_file() and not _is_right(folder / name, model):
            (folder / name).unlink()
        return Path(store.fetch(name, downloader=download))  # pyright: ignore[reportArgumentType]
    except requests.exceptions.HTTPError as error:
        raise ModelDataError(f"{model.url} could not be downloaded: the server answered {error}.") from error
    except requests.exceptions.RequestException as error:
        raise ModelDataError(
            f"{model.url} could not be downloaded ({type(error).__name__}); check the network, "
            "or set LPCOMPARE_MODELS to a folder that holds the file."
        ) from error
    except ValueError as error:
        raise ModelDataError(_WRONG.format(model.url)) from error
    except OSError as error:
        raise ModelDataError(
            f"The cache folder {folder} cannot be written ({error.strerror or error}); make room or allow it."
        ) from error


def _is_right(path: Path, model: Model) -> bool:
    """Whether a file has the checksum of an entry."""
    content = path.read_bytes()
    if model.sha256:
        return hashlib.sha256(content).hexdigest() == model.sha256
    head = f"blob {len(content)}\0".encode()
    return hashlib.sha1(head + content, usedforsecurity=False).hexdigest() == model.git_blob


def _wheel() -> Path:
    """The folder of pymeshlab, which is not imported for it."""
    spec = find_spec("pymeshlab")
    if spec is None or not spec.submodule_search_locations:
        raise ModelDataError(
            "This model is a file of pymeshlab, which is not installed; pip install pymeshlab."
        )
    return Path(spec.submodule_search_locations[0])
