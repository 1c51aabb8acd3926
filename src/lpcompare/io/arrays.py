"""NumPy files: .npy with points, .npz with points and one array per attribute; clouds for child processes."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError
from lpcompare.files import CONTINUE, whole_file
from lpcompare.io.columns import Holds, exactly, fractions, lost_digits
from lpcompare.io.faces import checked_triangles
from lpcompare.io.rows import Damaged
from lpcompare.types import Indices, PointCloud

_ARRAY, _ARCHIVE = b"\x93NUMPY", b"PK"
_FIELDS = ("points", "normals", "colors", "faces")
_ATTRIBUTE = "attribute:"
_LARGEST = 2**30
_LARGEST_RATIO = 100

HOLDS = {
    ".npy": Holds(types=("f8",), vectors=True, only=("columns",)),
    ".npz": Holds(
        types=("f8",), normals="f8", colors="f8", faces=True, whole=True,
        unfit=r"[\x00-\x1f\x7f\ud800-\udfff]", reserved=_FIELDS,
    ),
}  # fmt: skip


def read(path: Path) -> PointCloud:
    """An array (n, 3) of an .npy, further columns as ``columns``; the arrays of an .npz by their names."""
    content = _load(path)
    return _from_array(content, path) if isinstance(content, np.ndarray) else _from_archive(content, path)


def write(path: Path, cloud: PointCloud) -> None:
    """An .npy of the coordinates alone, or an .npz of everything."""
    with path.open("wb") as file:
        if path.suffix.lower() == ".npy":
            np.save(file, np.column_stack([cloud.points, *(v for v in cloud.attributes.values())]))
        else:
            _save(file, packed(cloud, ""))


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same arrays, in their own types, with some of their rows; arrays of another length stay whole."""
    content = _load(source)
    with target.open("wb") as out:
        if isinstance(content, np.ndarray):
            np.save(out, content[rows])
        else:
            n = len(content["points"])
            kept = {
                name: v[rows] if v.ndim and len(v) == n else v
                for name, v in content.items()
                if name != "faces"
            }
            _save(out, kept)
    return ()


def _load(path: Path) -> NDArray[Any] | dict[str, NDArray[Any]]:
    """The array, or the arrays by name.

    Raises
    ------
    Damaged
        No file of NumPy's, or an archive that would fill the memory.
    """
    with path.open("rb") as file:
        begin = file.read(len(_ARRAY))
        file.seek(0)
        if begin == _ARRAY:
            return np.load(file, allow_pickle=False)
        if not begin.startswith(_ARCHIVE):
            raise Damaged("it begins neither as an array of NumPy nor as a zip of them")
        with zipfile.ZipFile(file) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > max(_LARGEST, _LARGEST_RATIO * path.stat().st_size):
            raise Damaged(f"its {path.stat().st_size} bytes would become {size}")
        file.seek(0)
        with np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}


def _save(file: IO[bytes], arrays: Mapping[str, NDArray[Any]]) -> None:
    """What ``numpy.savez_compressed`` writes, under any name, "file" too."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asanyarray(array), allow_pickle=False)


def _from_array(array: NDArray[Any], path: Path) -> PointCloud:
    if array.ndim == 2 and array.shape[0] == 3 < array.shape[1]:
        raise Damaged(f"its array has the shape {array.shape}, which is transposed; save array.T")
    if array.ndim != 2 or array.shape[1] < 3:
        raise Damaged(f"its array has the shape {array.shape}; points have the shape (n, 3)")
    more = {"columns": array[:, 3:]} if array.shape[1] > 3 else {}
    beside = lost_digits(array[:, :3])
    return PointCloud(_points(array[:, :3]), attributes=more, name=path.stem, beside=beside)


def _from_archive(arrays: Mapping[str, NDArray[Any]], path: Path) -> PointCloud:
    if "points" not in arrays:
        raise Damaged(f"it has no array 'points', only {', '.join(sorted(arrays))[:200] or 'nothing'}")
    points = _points(arrays["points"])
    faces = arrays.get("faces")
    if faces is not None:
        corners = exactly(faces.reshape(-1, 3), np.intp) if faces.dtype.kind in "iuf" else None
        if corners is None:
            raise Damaged(f"its faces of type {faces.dtype} are no numbers of points")
        faces = checked_triangles(corners, len(points))
    colors = _rows_of(arrays.get("colors"), len(points), (3, 4))
    normals = _rows_of(arrays.get("normals"), len(points), (3,))
    others = {k: v for k, v in arrays.items() if k not in _FIELDS and v.ndim and len(v) == len(points)}
    known = {*_FIELDS, *others}
    return PointCloud(
        points,
        normals=None if normals is None else normals.astype(np.float64),
        colors=None if colors is None else fractions(*colors.T),
        attributes=others,
        faces=faces,
        name=path.stem,
        beside=(*lost_digits(arrays["points"]), *(f"its array {k!r}" for k in arrays if k not in known)),
    )


def _points(array: NDArray[Any]) -> NDArray[np.float64]:
    if array.ndim != 2 or array.shape[1] != 3 or not len(array) or array.dtype.kind not in "iuf":
        raise Damaged(
            f"its points have the shape {array.shape} and type {array.dtype}; they must be numbers (n, 3)"
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def _rows_of(array: NDArray[Any] | None, n_points: int, widths: tuple[int, ...]) -> NDArray[Any] | None:
    if array is None:
        return None
    if array.shape not in [(n_points, width) for width in widths] or array.dtype.kind not in "iuf":
        raise Damaged(f"an array has the shape {array.shape} where {(n_points, widths[-1])} is needed")
    return array


def save_arrays(path: Path, arrays: Mapping[str, NDArray[Any]], remedy: str = CONTINUE) -> None:
    """Write an .npz whole or not at all; raises `InputError` with the remedy where it cannot be written."""
    with whole_file(path, remedy) as part, part.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


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


def save_cloud(path: Path, cloud: PointCloud, remedy: str = CONTINUE) -> None:
    """Write a cloud with everything that it carries but lists; raises `InputError` as `save_arrays` does."""
    save_arrays(path, packed(cloud), remedy)


def load_cloud(path: Path) -> PointCloud:
    """Read what `save_cloud` wrote; raises `InputError` as `load_arrays` does."""
    return unpacked(load_arrays(path), path.stem)


def digest(cloud: PointCloud) -> str:
    """SHA-256 of all that a method can see of a cloud."""
    state = hashlib.sha256()
    for name, array in sorted(packed(cloud).items()):
        state.update(f"{name} {array.dtype} {array.shape}".encode())
        state.update(np.ascontiguousarray(array).data)
    return state.hexdigest()


def packed(cloud: PointCloud, prefix: str = _ATTRIBUTE) -> dict[str, NDArray[Any]]:
    """The cloud as named arrays; its name and lists of several lengths are not among them."""
    own = {name: getattr(cloud, name) for name in _FIELDS if getattr(cloud, name) is not None}
    more = {prefix + name: np.asarray(v) for name, v in cloud.attributes.items()}
    return own | {name: values for name, values in more.items() if not values.dtype.hasobject}


def unpacked(arrays: Mapping[str, NDArray[Any]], name: str) -> PointCloud:
    """The cloud of `packed` arrays."""
    attributes = {k.removeprefix(_ATTRIBUTE): v for k, v in arrays.items() if k.startswith(_ATTRIBUTE)}
    own: dict[str, Any] = {k: arrays[k] for k in _FIELDS if k in arrays}
    return PointCloud(**own, attributes=attributes, name=name)
