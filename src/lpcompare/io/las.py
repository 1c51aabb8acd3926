"""LAS, LAZ and COPC (laspy): every dimension, scale, offset and coordinate reference system."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import laspy
import numpy as np
from laspy.header import Version
from laspy.vlrs.vlrlist import VLRList
from numpy.typing import NDArray

from lpcompare.io.checks import check_held, checked_points
from lpcompare.io.las_header import check_header, largest_chunk
from lpcompare.types import Indices, PointCloud

HOLDS = frozenset({"colors", "attributes"})

_COLORS = ("red", "green", "blue")
_LARGEST_INTEGER = 2**31 - 1
_LONGEST_NAME = 32


def read(path: Path) -> PointCloud:
    """Scaled coordinates; colours from 0 to 1; every other dimension under its name."""
    file = _open(path)
    names = [name for name in file.point_format.dimension_names if name not in ("X", "Y", "Z")]
    colors = _colors(file) if set(_COLORS) <= set(names) else None
    points = checked_points(np.asarray(file.xyz), path.name)
    attributes = {n: np.array(file[n]) for n in names if colors is None or n not in _COLORS}
    return PointCloud(points, colors=colors, attributes=attributes, name=path.stem)


def write(path: Path, cloud: PointCloud) -> None:
    """LAS 1.4, coordinates in steps of a power of ten that is fine enough to use all 32 bits."""
    header = laspy.LasHeader(version="1.4", point_format=6 if cloud.colors is None else 7)
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    step = max(float((high - low).max()) / _LARGEST_INTEGER, np.spacing(np.abs(cloud.points).max()))
    header.scales = np.full(3, 10.0 ** np.ceil(np.log10(max(step, 1e-12))))
    header.offsets = np.floor(low)
    known = set(header.point_format.dimension_names)
    extra = {n[:_LONGEST_NAME]: v for n, v in _columns(cloud).items() if n not in known}
    header.add_extra_dims([laspy.ExtraBytesParams(name=n, type=_type(v)) for n, v in extra.items()])
    file = laspy.LasData(header)
    file.x, file.y, file.z = cloud.points.T
    for name, values in {**extra, **{n: v for n, v in cloud.attributes.items() if n in known}}.items():
        file[name] = values
    if cloud.colors is not None:
        for name, values in zip(_COLORS, cloud.colors.T, strict=False):
            file[name] = np.rint(np.clip(values, 0, 1) * 65535).astype(np.uint16)
    file.write(str(path))


def _columns(cloud: PointCloud) -> dict[str, NDArray[Any]]:
    """The attributes, those of several columns as one dimension for each: name_0, name_1, ..."""
    columns: dict[str, NDArray[Any]] = {}
    for name, values in cloud.attributes.items():
        if values.ndim == 1:
            columns[name] = values
        else:
            short = name[: _LONGEST_NAME - 4]
            columns |= {f"{short}_{i}": v for i, v in enumerate(values.reshape(len(values), -1).T)}
    return columns


def keep_rows(source: Path, target: Path, rows: Indices) -> None:
    """The same file with some of its points; a COPC becomes a plain LAZ, because its tree no longer holds."""
    file = _open(source)
    file.points = laspy.ScaleAwarePointRecord(
        file.points.array[rows], file.point_format, file.header.scales, file.header.offsets
    )
    if "copc" in {record.user_id for record in [*file.vlrs, *(file.evlrs or ())]}:
        file.vlrs = [record for record in file.vlrs if record.user_id != "copc"]
        file.evlrs = VLRList([record for record in file.evlrs or () if record.user_id != "copc"])
    if file.header.version.minor == 0:
        file.header.version = Version(1, 1)  # of the same layout, and laspy writes no 1.0
    _write(target, file)


def _write(path: Path, file: laspy.LasData) -> None:
    """The file with names in the header as they are, also those that are not ASCII."""
    how = {"do_compress": path.suffix.lower() == ".laz", "encoding_errors": "ignore", "closefd": False}
    with path.open("wb") as out, laspy.LasWriter(out, file.header, **how) as writer:
        writer.write_points(file.points)
        if file.evlrs:
            writer.write_evlrs(file.evlrs)


def _open(path: Path) -> laspy.LasData:
    """The whole file; shorter than its header says is a `ValueError`."""
    check_header(path)
    with laspy.open(str(path)) as reader:
        promised = reader.header.point_count
        if reader.header.are_points_compressed and largest_chunk(path, reader.header) > promised:
            reader.laz_backend = laspy.LazBackend.Lazrs  # the parallel one takes memory for a full chunk
        file = reader.read()
    check_held("points", promised, len(file.points))
    return file


def _colors(file: laspy.LasData) -> NDArray[np.float64]:
    """Colours of 16 bits; many files hold 8 bits in them, which the largest value shows."""
    channels = np.column_stack([np.asarray(file[n], dtype=np.float64) for n in _COLORS])
    largest = 65535.0 if channels.size and channels.max() > 255 else 255.0
    return np.column_stack([channels / largest, np.ones(len(channels))])


def _type(values: NDArray[Any]) -> str:
    """The extra-bytes type of an attribute; LAS has no booleans."""
    return "u1" if values.dtype.kind == "b" else values.dtype.str[1:]
