"""LAS, LAZ and COPC in parts (laspy): every dimension, header, record and coordinate reference system stays."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import laspy
import numpy as np

from lpcompare.io.las import (
    appending,
    check_header,
    coordinate_system,
    keep_waveforms,
    largest_chunk,
    make_writable,
    waveforms_lost,
    waveforms_start,
)
from lpcompare.io.rows import Damaged, check_held
from lpcompare.tiles.streams import Append
from lpcompare.types import Points


def count_points(path: Path) -> int:
    """How many points the header promises; raises `Damaged` where the file cannot hold them."""
    check_header(path)
    with laspy.open(str(path)) as reader:
        if reader.header.are_points_compressed:
            largest_chunk(path, reader.header)
        return reader.header.point_count


def note_on(path: Path) -> str:
    """What a copy of some of the points leaves out."""
    header = _header(path)
    tree = {record.user_id for record in header.vlrs} & {"copc"}
    return "; ".join([*["a COPC becomes a plain LAZ"] * bool(tree), *waveforms_lost(path, header)])


def read_rows(path: Path, start: int, stop: int) -> tuple[Points, laspy.ScaleAwarePointRecord]:
    """Scaled coordinates of the points ``start`` to ``stop``, and their records."""
    with laspy.open(str(path), laz_backend=laspy.LazBackend.Lazrs) as reader:
        if start:
            reader.seek(start)
        records = reader.read_points(stop - start)
    check_held("points", stop - start, len(records))
    points = np.column_stack([np.asarray(records[axis], dtype=np.float64) for axis in "xyz"])
    return points, records


@contextmanager
def writer(path: Path, source: Path, count: int) -> Iterator[Append]:
    """Write the header of ``source``; records are appended and the counts of the header follow them."""
    header = _header(source)
    make_writable(header)
    with path.open("wb") as out, appending(path, out, header) as (las, write):

        def append(other: Path, records: laspy.ScaleAwarePointRecord) -> None:
            if records.point_format != header.point_format:
                raise Damaged(f"{other.name} has another point format than {source.name}")
            if other != source:
                _check_alike(other, source)
            if (records.scales != header.scales).any() or (records.offsets != header.offsets).any():
                records = _on_grid(other, records, header)
            write(records)

        yield append
        if header.evlrs:
            las.write_evlrs(header.evlrs)
    keep_waveforms(source, path, header)


def _header(path: Path) -> laspy.LasHeader:
    with laspy.open(str(path)) as reader:
        header = copy.deepcopy(reader.header)
        header.evlrs = reader.evlrs
    return header


def _check_alike(other: Path, source: Path) -> None:
    """Raise a `Damaged` where points of one file would be misread under the header of another."""
    theirs, ours = _header(other), _header(source)
    if coordinate_system(theirs) != coordinate_system(ours):
        raise Damaged(
            f"{other.name} has another coordinate reference system than {source.name}; write to a folder instead"
        )
    if waveforms_start(theirs) or waveforms_start(ours):
        raise Damaged(
            f"{other.name} and {source.name} have waveforms of their own, which one file cannot keep; "
            "write to a folder instead"
        )


def _on_grid(
    other: Path, records: laspy.ScaleAwarePointRecord, header: laspy.LasHeader
) -> laspy.ScaleAwarePointRecord:
    """The records in the steps of the file that is written."""
    records = laspy.ScaleAwarePointRecord(
        records.array.copy(), records.point_format, records.scales, records.offsets
    )
    try:
        records.change_scaling(header.scales, header.offsets)
    except OverflowError as error:
        raise Damaged(
            f"{other.name} lies too far away for the steps of the first file; write to a folder instead"
        ) from error
    return records
