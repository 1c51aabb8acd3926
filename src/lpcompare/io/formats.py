"""Which file of this folder reads and writes which format, and what is said of files that cannot be read."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from lpcompare.errors import InputError, LpcompareError
from lpcompare.files import check_unchanged, state_of, whole_file
from lpcompare.interplay import read_object
from lpcompare.io import isolated
from lpcompare.io.columns import fitted
from lpcompare.io.rows import Damaged
from lpcompare.types import Indices, PointCloud

_FAMILIES = {
    "ply": (".ply",),
    "obj": (".obj",),
    "off": (".off",),
    "text": (".asc", ".csv", ".pts", ".txt", ".xyz"),
    "las": (".las", ".laz"),
    "pcd": (".pcd",),
    "arrays": (".npy", ".npz"),
}
_FAMILY = {suffix: family for family, suffixes in _FAMILIES.items() for suffix in suffixes}
_READ_BY_MESHLAB = (
    *(".3ds", ".apts", ".ctm", ".dae", ".e57", ".fbx", ".glb", ".gltf", ".stl", ".tri", ".wrl"),
    *(".x3d", ".x3dv"),
)
_READ_ONLY = {".ptx": "text"} | dict.fromkeys(_READ_BY_MESHLAB, "foreign")


def read(path: str | os.PathLike[str], *, drop_invalid: bool = False) -> PointCloud:
    r"""Read a point cloud with every attribute that its format gives each point.

    Parameters
    ----------
    path : str or path
        The ending names the format.
    drop_invalid : bool, default False
        Leave out points that have a coordinate that is NaN or infinite, as scanners write for a ray without
        an echo. They are kept by default, so that rows of the cloud are those of the file.

    Returns
    -------
    PointCloud
        ``points`` has shape (n, 3), in the unit of the file. Faces of more than three sides are cut into
        triangles; vertices without a face are kept.

    Raises
    ------
    InputError
        There is no such file, the format is not known, or the file is empty, damaged or shorter than it says.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "scan.csv").write_text("x,y,z,intensity\n1,2,3,7\n4,5,nan,8\n")
    >>> cloud = read(folder / "scan.csv")
    >>> cloud.points.shape, cloud.attributes["intensity"]
    ((2, 3), array([7., 8.]))
    >>> len(read(folder / "scan.csv", drop_invalid=True))
    1
    """
    path = Path(path)
    with _sentences(path), np.errstate(all="ignore"):
        _check_source(path)
        family, state = _family(path), state_of(path)
        try:
            cloud = isolated.read(family, path) if _isolated(family, path) else _module(family).read(path)
        finally:
            check_unchanged(path, state)  # it says more than that half a file is damaged
    invalid = ~np.isfinite(cloud.points).all(axis=1, keepdims=True).ravel()
    return cloud.take(~invalid) if drop_invalid and invalid.any() else cloud


def write(path: str | os.PathLike[str], cloud: Any) -> tuple[str, ...]:
    """Write a cloud with its attributes; the file appears under its name only when it is complete.

    Parameters
    ----------
    path : str or path
        The ending names the format; a file of that name is replaced, and its mode kept.
    cloud : PointCloud, array_like of shape (n, 3), or an object that `simplify` takes
        The file has the unit of its coordinates.

    Returns
    -------
    tuple of str
        What the format cannot hold as it was: a part that is left out, a name that is spelt in another way,
        values that are rounded. Empty where a reader gets back what the cloud had.

    Raises
    ------
    InputError
        The format cannot be written or cannot hold the coordinates, a part of the cloud has not a row for
        each point, or the folder does not exist or is not writable.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import numpy as np
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> cloud = PointCloud(np.eye(3), attributes={"id": np.array([7, 8, 9])})
    >>> write(folder / "scan.ply", cloud)
    ()
    >>> write(folder / "scan.off", cloud)
    ('.off holds no attributes',)
    """
    path = Path(path)
    module = _module(_writable(path))
    _check_folder(path)
    cloud = read_object(cloud)
    try:
        with np.errstate(all="ignore"), whole_file(path) as part:
            fit, notes = fitted(cloud, module.HOLDS[path.suffix.lower()], path.suffix.lower())
            module.write(part, fit)
    except Damaged as error:
        raise InputError(f"{path} cannot be written: {error}.") from error
    return notes


def keep_rows(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    rows: Indices,
    state: tuple[int, int, int] | None = None,
) -> tuple[str, ...]:
    """Copy a file with some of its points: values, further properties, comments and header stay as they are.

    Parameters
    ----------
    source, target : str or path
        Files of the same format. The target may be the source.
    rows : ndarray of int, shape (m,)
        Points to keep, ascending.
    state : tuple of int, optional
        What `state_of` said of the source when the rows were chosen; it must be so still.

    Returns
    -------
    tuple of str
        What does not stay, as `write` says it; faces are left out without a word.

    Raises
    ------
    InputError
        As `read` and `write`.
    """
    source, target = Path(source), Path(target)
    family = _writable(target)
    with _sentences(source):
        _check_source(source)
        if not same_format(source, target):
            raise InputError(
                f"{source.name} and {target.name} are not of one format; write the cloud instead."
            )
    _check_folder(target)
    with _sentences(source), np.errstate(all="ignore"), whole_file(target) as part:
        state = state or state_of(source)
        try:
            if _isolated(family, source):
                return isolated.keep_rows(family, source, part, rows)
            return _module(family).keep_rows(source, part, rows)
        finally:
            check_unchanged(source, state)


def same_format(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> bool:
    """Whether `keep_rows` can copy one file to the other."""
    source, target = Path(source), Path(target)
    family = _family(source)
    alike = family != "arrays" or source.suffix.lower() == target.suffix.lower()
    return source.suffix.lower() != ".ptx" and alike and family == _FAMILY.get(target.suffix.lower())


def check_target(path: str | os.PathLike[str]) -> None:
    """Raise an `InputError` now if ``path`` could not be written later."""
    _writable(Path(path))
    _check_folder(Path(path))


@contextmanager
def _sentences(path: Path) -> Iterator[None]:
    """Whatever is wrong with a file, as one sentence that names it, without a library's own text."""
    kind = path.suffix.lower().removeprefix(".").upper()
    try:
        yield
    except LpcompareError:
        raise
    except Damaged as error:
        reason = str(error) if str(error).endswith("?") else f"{error}."
        raise InputError(f"{path} cannot be read as {kind}: {reason}") from error
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or 'it is damaged'}.") from error
    except MemoryError as error:
        raise InputError(f"{path} cannot be read: it needs more memory than there is.") from error
    except Exception as error:
        raise InputError(f"{path} cannot be read as {kind}: it is damaged, or not of this format.") from error


def _check_source(path: Path) -> None:
    if path.is_dir():
        raise InputError(f"{path} is a folder; name a file.")
    if str(path) == "-" and not path.exists():
        raise InputError("Standard input cannot be read; write it to a file first and name that.")
    size = path.stat().st_size
    if not path.is_file():
        raise InputError(f"{path} is no regular file but a pipe or device; write it to a file first.")
    if size == 0:
        raise InputError(f"{path} is empty (0 bytes); export it again.")
    path.open("rb").close()  # what may not be read needs no reader


def _check_folder(path: Path) -> None:
    """The file behind the links, or its folder, must be able to take a file's place."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        raise InputError(f"{path} is not a file; name a file to write.")
    if not target.parent.is_dir():
        raise InputError(f"The folder {target.parent} does not exist; create it or name another.")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(f"The folder {target.parent} cannot be written to; name another.")


def _module(family: str) -> ModuleType:
    return import_module(f"lpcompare.io.{family}")


def _isolated(family: str, path: Path) -> bool:
    """Whether the reader could end the whole process."""
    return family == "foreign" or path.suffix.lower() == ".laz"


def _family(path: Path) -> str:
    """Name of the file of this folder that reads the format."""
    suffix = path.suffix.lower()
    if suffix == ".pts" and path.is_file() and _begins_with(path, b"["):
        suffix = ".apts"  # MeshLab's binary point sets share the ending of plain rows
    families = _FAMILY | _READ_ONLY
    if suffix not in families:
        known = " ".join(sorted(families))
        raise InputError(f"{path} has the ending {suffix!r}, which is not known. Known: {known}.")
    return families[suffix]


def _begins_with(path: Path, mark: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(len(mark)) == mark


def _writable(path: Path) -> str:
    """Name of the file of this folder that writes the format."""
    suffix = path.suffix.lower()
    if suffix not in _FAMILY:
        raise InputError(f"Files {suffix!r} cannot be written ({path}). Known: {' '.join(sorted(_FAMILY))}.")
    if path.name.lower().endswith(".copc.laz"):
        raise InputError(f"{path}: COPC cannot be written; name a file that ends in .laz alone.")
    return _FAMILY[suffix]
