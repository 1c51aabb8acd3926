"""Which file of this folder reads and writes which format, and what is said of files that cannot be read."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType

from lpcompare.errors import InputError, LpcompareError
from lpcompare.io import isolated
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
_ISOLATED = ("las", "foreign")
_READ_BY_MESHLAB = (
    *(".3ds", ".apts", ".ctm", ".dae", ".e57", ".fbx", ".glb", ".gltf", ".stl", ".tri", ".wrl"),
    *(".x3d", ".x3dv"),
)
_READ_ONLY = {".ptx": "ptx"} | dict.fromkeys(_READ_BY_MESHLAB, "foreign")


def read_point_cloud(path: str | os.PathLike[str]) -> PointCloud:
    """Read a point cloud with every attribute that its format gives each point.

    Parameters
    ----------
    path : str or path
        The ending names the format.

    Returns
    -------
    PointCloud
        Faces of more than three sides are cut into triangles; vertices without a face are kept.

    Raises
    ------
    InputError
        There is no such file, the format is not known, the file is empty, damaged or shorter than it says,
        or a coordinate is not finite.
    """
    path = Path(path)
    with _sentences(path):
        _check_source(path)
        family = _family(path)
        return isolated.read(family, path) if family in _ISOLATED else _module(family).read(path)


def write_point_cloud(path: str | os.PathLike[str], cloud: PointCloud) -> None:
    """Write a cloud with its attributes; the file appears under its name only when it is complete.

    Parameters
    ----------
    path : str or path
        The ending names the format; a file of that name is replaced.
    cloud : PointCloud

    Raises
    ------
    InputError
        The format cannot be written or holds no such attribute, or the folder does not exist or is not
        writable.
    """
    path = Path(path)
    family = _writable(path)
    if family != "arrays":
        _check_numbers(path, cloud)
    with beside(path) as part:
        _module(family).write(part, cloud)


def keep_rows(source: str | os.PathLike[str], target: str | os.PathLike[str], rows: Indices) -> None:
    """Copy a file with some of its points: values, further properties, comments and header stay as they are.

    Parameters
    ----------
    source, target : str or path
        Files of the same format. The target may be the source.
    rows : ndarray of int, shape (m,)
        Points to keep, ascending.

    Raises
    ------
    InputError
        As `read_point_cloud` and `write_point_cloud`.
    """
    source, target = Path(source), Path(target)
    family = _writable(target)
    if _family(source) != family:
        raise InputError(f"{source.name} and {target.name} are not of one format; write the cloud instead.")
    with _sentences(source), beside(target) as part:
        if family in _ISOLATED:
            isolated.keep_rows(family, source, part, rows)
        else:
            _module(family).keep_rows(source, part, rows)


def same_format(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> bool:
    """Whether `keep_rows` can copy one file to the other."""
    return _family(Path(source)) == _FAMILY.get(Path(target).suffix.lower())


def left_out(path: str | os.PathLike[str], cloud: PointCloud) -> tuple[str, ...]:
    """What of a cloud the format of ``path`` cannot hold: "normals", "colors", "attributes", "faces"."""
    holds = _module(_writable(Path(path))).HOLDS
    if Path(path).suffix.lower() == ".npy":
        holds = {"attributes"} if cloud.attributes.keys() <= {"columns"} else set()
    parts = ("normals", "colors", "attributes", "faces")
    return tuple(part for part in parts if _has(cloud, part) and part not in holds)


def check_target(path: str | os.PathLike[str]) -> None:
    """Raise an `InputError` now if ``path`` could not be written later."""
    _writable(Path(path))
    target = _real_target(Path(path))
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(f"The folder {Path(path).parent} cannot be written to; name another.")


@contextmanager
def beside(path: Path) -> Iterator[Path]:
    """A file in the same folder that takes the name ``path`` once the block has ended well."""
    target = _real_target(path)
    part = target.with_name(f".{os.getpid()}.{target.name}")
    try:
        yield part
        os.replace(part, target)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}.") from error
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def _sentences(path: Path) -> Iterator[None]:
    """Whatever a parser says of a damaged file, as one sentence that names the file."""
    try:
        yield
    except LpcompareError:
        raise
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from error
    except Exception as error:
        reason = " ".join(str(error).split()).rstrip(".")[:200] or type(error).__name__
        kind = path.suffix.lower().removeprefix(".").upper()
        raise InputError(f"{path} cannot be read as {kind}: {reason}; is the file complete?") from error


def _check_source(path: Path) -> None:
    if path.is_dir():
        raise InputError(f"{path} is a folder; name a file.")
    if path.stat().st_size == 0 and path.is_file():
        raise InputError(f"{path} is empty (0 bytes); export it again.")
    if path.is_file():
        path.open("rb").close()  # what may not be read needs no reader


def _real_target(path: Path) -> Path:
    """The file behind the links; it or its folder must be able to take a file's place."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        raise InputError(f"{path} is not a file; name a file to write.")
    if not target.parent.is_dir():
        raise InputError(f"The folder {path.parent} does not exist; create it or name another.")
    return target


def _check_numbers(path: Path, cloud: PointCloud) -> None:
    for name, values in cloud.attributes.items():
        if values.dtype.kind not in "biuf":
            raise InputError(
                f"{path} cannot hold the attribute {name!r} of type {values.dtype}, only real numbers; "
                "write to .npz, or remove the attribute."
            )


def _has(cloud: PointCloud, part: str) -> bool:
    value = getattr(cloud, part)
    return bool(value) if part == "attributes" else value is not None


def _module(family: str) -> ModuleType:
    return import_module(f"lpcompare.io.{family}")


def _family(path: Path) -> str:
    """Name of the file of this folder that reads the format."""
    suffix = path.suffix.lower()
    if suffix == ".pts" and _begins_with(path, b"["):
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
