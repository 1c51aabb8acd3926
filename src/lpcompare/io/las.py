"""LAS, LAZ and COPC (laspy): every dimension, scale, offset and coordinate reference system.

What a file promises is held against its size before laspy believes it: laspy makes an object for every
promised record and a byte for every promised byte of points, found or not.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import laspy
import numpy as np
from laspy.header import Version
from laspy.vlrs.vlrlist import VLRList
from lazrs.lazrs import LazVlr, read_chunk_table
from numpy.typing import NDArray

from lpcompare.errors import InputError
from lpcompare.io.columns import AXES, COLORS, NORMALS, NUMBERS, Holds, by_name, cloud_of, columns_of
from lpcompare.io.rows import Damaged, check_held, check_room
from lpcompare.types import Indices, PointCloud

_FIELDS = {
    **{
        "intensity": ("u2", 0, 65535),
        "point_source_id": ("u2", 0, 65535),
        "scan_angle": ("i2", -32768, 32767),
    },
    **{"classification": ("u1", 0, 255), "user_data": ("u1", 0, 255), "gps_time": ("f8", None, None)},
    **{"return_number": ("u1", 0, 15), "number_of_returns": ("u1", 0, 15), "scanner_channel": ("u1", 0, 3)},
    **dict.fromkeys(("synthetic", "key_point", "withheld", "overlap"), ("u1", 0, 1)),
    **dict.fromkeys(("scan_direction_flag", "edge_of_flight_line"), ("u1", 0, 1)),
}
_PARTS = ("X", "Y", "Z", "bit_fields", "classification_flags")

HOLDS = dict.fromkeys(
    (".las", ".laz"),
    Holds(
        types=NUMBERS,
        normals="f8",
        colors="u2",
        alpha=False,
        unfit=r"[:\x00-\x1f\x7f\ud800-\udfff]+",
        longest=32,
        reserved=(*AXES, *NORMALS, *COLORS[:3], *_PARTS),
        fields=_FIELDS,
        most=330,
    ),
)

_LARGEST_INTEGER = 2**31 - 1
_WAVEFORMS_AT = 227
_WAVEFORM_RECORD = (b"LASF_Spec", 65535)

_FIRST = struct.Struct("<24xBB68xHIIBHI")  # version, sizes and counts, the same in every version
_EXTENDED = struct.Struct("<235xQIQ")  # the additions of version 1.4
_SMALLEST = 227
_RECORD_BYTES = 54
_EXTENDED_RECORD = struct.Struct("<2x16sHQ32x")
_COMPRESSED, _COMPRESSION = 0x80, 0xC0
_POINTWISE, _LAYERED = b"\1\0", b"\3\0"
_ITEM = struct.Struct("<HH2x")  # a part of a compressed point: kind, bytes, version
_FIRST_ITEM_AT = 34
_OF_THE_POINTS = (("LASF_Spec", 4), ("laszip encoded", 22204), ("copc", 1), ("copc", 1000), _WAVEFORM_RECORD)
_LAYERED_WAVES = (9, 10)  # point formats that lazrs compresses wrongly where the scanner channel changes
_LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}  # of the kinds of part; extra bytes have a layer each


def read(path: Path) -> PointCloud:
    """Scaled coordinates; colours from 0 to 1; every other dimension under its name."""
    file = _open(path)
    names = [name for name in file.point_format.dimension_names if name not in ("X", "Y", "Z")]
    columns = [*np.asarray(file.xyz).T, *(np.array(file[name]) for name in names)]
    return cloud_of(by_name([*AXES, *names], columns), path.stem, beside=_beside(file.header))


def coordinate_system(header: laspy.LasHeader) -> list[tuple[int, bytes]]:
    """The records that say the coordinate reference system, by their numbers."""
    records = [*header.vlrs, *(header.evlrs or ())]
    system = [record for record in records if record.user_id == "LASF_Projection"]
    return sorted((record.record_id, record.record_data_bytes().rstrip(b"\0")) for record in system)


def _beside(header: laspy.LasHeader) -> list[str]:
    """What the header has that is said of no single point."""
    records, system = [*header.vlrs, *(header.evlrs or ())], coordinate_system(header)
    more = sum((record.user_id, record.record_id) not in _OF_THE_POINTS for record in records) - len(system)
    named = {"its coordinate reference system": system, "its waveforms": waveforms_start(header)}
    return [name for name, there in named.items() if there] + [f"{more} further records of its header"] * (
        more > 0
    )


def write(path: Path, cloud: PointCloud) -> None:
    """LAS 1.4, coordinates in steps of a power of ten that is fine enough to use all 32 bits."""
    header = laspy.LasHeader(version="1.4", point_format=6 if cloud.colors is None else 7)
    header.scales, header.offsets = _grid(cloud.points)
    columns = {name: values for name, values in columns_of(cloud).items() if name not in AXES}
    known = set(header.point_format.dimension_names)
    extra = {name: values.dtype.str[1:] for name, values in columns.items() if name not in known}
    header.add_extra_dims([laspy.ExtraBytesParams(name=name, type=kind) for name, kind in extra.items()])
    file = laspy.LasData(header)
    file.x, file.y, file.z = cloud.points.T
    for name, values in columns.items():
        file[name] = values
    file.write(str(path))


def _grid(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Step and origin, each (3,), with which every coordinate is an integer of 32 bits."""
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float((high - low).max())
    if not np.isfinite(extent):
        raise Damaged("coordinates are NaN or infinite, which LAS cannot hold; leave these points out")
    unit = min(1.0, 10.0 ** np.ceil(np.log10(extent))) if extent else 0.0
    origin = np.floor(low / unit) * unit if unit else low
    finest = max(extent / _LARGEST_INTEGER, float(np.spacing(np.abs(points).max())), 1e-300)
    scale = 10.0 ** np.ceil(np.log10(finest))
    while (high - origin).max() / scale > _LARGEST_INTEGER:
        scale *= 10
    return np.full(3, scale), origin


def keep_rows(source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """The same file with some of its points; a COPC becomes a plain LAZ, because its tree no longer holds."""
    file = _open(source)
    file.points = laspy.ScaleAwarePointRecord(
        file.points.array[rows], file.point_format, file.header.scales, file.header.offsets
    )
    make_writable(file.header)
    _write(target, file)
    keep_waveforms(source, target, file.header)
    return waveforms_lost(source, file.header)


def make_writable(header: laspy.LasHeader) -> None:
    """Take out of a header what a file with other points cannot have: COPC's tree, and version 1.0."""
    header.vlrs = VLRList([record for record in header.vlrs if record.user_id != "copc"])
    if header.evlrs is not None:
        header.evlrs = VLRList([record for record in header.evlrs if record.user_id != "copc"])
    if header.version.minor == 0:
        header.version = Version(1, 1)  # of the same layout, and laspy writes no 1.0


def _write(path: Path, file: laspy.LasData) -> None:
    """The file with names in the header as they are, also those that are not ASCII.

    Raises
    ------
    InputError
        As `appending`.
    """
    with path.open("wb") as out, appending(path, out, file.header) as (writer, append):
        append(file.points)
        if file.evlrs:
            writer.write_evlrs(file.evlrs)


@contextmanager
def appending(
    path: Path, out: BinaryIO, header: laspy.LasHeader
) -> Iterator[tuple[laspy.LasWriter, Callable[[laspy.ScaleAwarePointRecord], None]]]:
    """A writer with a header, and what writes points with it; a name that ends in .laz is compressed.

    Raises
    ------
    InputError
        It would be a LAZ with wave packets of several scanner channels.
    """
    compressed = path.suffix.lower() == ".laz"
    waves = compressed and header.point_format.id in _LAYERED_WAVES
    how = {"do_compress": compressed, "encoding_errors": "ignore", "closefd": False}
    channels = set[int]()
    with laspy.LasWriter(out, header, **how) as writer:

        def append(points: laspy.ScaleAwarePointRecord) -> None:
            channels.update(
                np.unique(np.asarray(points["scanner_channel"], dtype=np.uint8)).tolist() if waves else ()
            )
            if len(channels) > 1:
                raise InputError(
                    "A LAZ of this point format cannot keep the wave packets of several scanner channels, "
                    "because its compressor changes them; name a file that ends in .las."
                )
            if len(points):
                writer.write_points(points)

        yield writer, append


def waveforms_lost(source: Path, header: laspy.LasHeader) -> tuple[str, ...]:
    """Say where a copy of some points has not the waveforms that they refer to."""
    start = waveforms_start(header)
    if not start:
        beside = header.version.minor >= 3 and header.global_encoding.waveform_data_packets_external
        return (f"its waveforms stay in {source.stem}.wdp",) if beside else ()
    with source.open("rb") as file:
        there = _waveforms(file, start)
    return () if there else ("its waveforms are left out, they are not where its header says",)


def waveforms_start(header: laspy.LasHeader) -> int:
    """Where the header says that the record of waveforms begins; 0 where there is none in the file."""
    return header.start_of_waveform_data_packet_record if header.version.minor >= 3 else 0


def keep_waveforms(source: Path, target: Path, header: laspy.LasHeader) -> None:
    """Copy the record of waveforms that points refer to and name its place."""
    start = waveforms_start(header)
    if not start:
        return
    with source.open("rb") as old, target.open("r+b") as new:
        length, place = _waveforms(old, start), 0
        if length:
            place = (_listed(new) if header.version.minor >= 4 else 0) or new.seek(0, 2)
            old.seek(start)
            new.seek(place)
            for at in range(0, length, 2**24):
                new.write(old.read(min(2**24, length - at)))
        new.seek(_WAVEFORMS_AT)
        new.write(struct.pack("<Q", place))


def _waveforms(file: BinaryIO, start: int) -> int:
    """Bytes of the record of waveforms that begins at a place of the file; 0 where it is none."""
    size = file.seek(0, 2)
    file.seek(start)
    head = file.read(_EXTENDED_RECORD.size)
    user, number, length = _EXTENDED_RECORD.unpack(head.ljust(_EXTENDED_RECORD.size))
    whole = length + _EXTENDED_RECORD.size
    return whole if (user.rstrip(b"\0"), number) == _WAVEFORM_RECORD and start + whole <= size else 0


def _listed(file: BinaryIO) -> int:
    """Where the record of waveforms is among the extended records; 0 where it is not."""
    file.seek(0)
    start, count, _ = _EXTENDED.unpack(file.read(_EXTENDED.size))
    for _ in range(count):
        if _waveforms(file, start):
            return start
        file.seek(start)
        start += _EXTENDED_RECORD.size + _EXTENDED_RECORD.unpack(file.read(_EXTENDED_RECORD.size))[2]
    return 0


def _open(path: Path) -> laspy.LasData:
    """The whole file; shorter than its header says is `Damaged`."""
    check_header(path)
    with laspy.open(str(path)) as reader:
        promised = reader.header.point_count
        if reader.header.are_points_compressed and largest_chunk(path, reader.header) > promised:
            reader.laz_backend = laspy.LazBackend.Lazrs  # the parallel one takes memory for a full chunk
        file = reader.read()
    check_held("points", promised, len(file.points))
    return file


def check_header(path: Path) -> None:
    """Raise a `Damaged` where records, or points that are not compressed, need more than the file."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_EXTENDED.size)
        if not head.startswith(b"LASF"):
            raise Damaged(f"it begins with {head[:4]!r}, not with b'LASF'")
        if len(head) < _SMALLEST:
            raise Damaged(f"it ends in the header, after {len(head)} of at least {_SMALLEST} bytes")
        major, minor, end, start, n_records, kind, length, n_points = _FIRST.unpack_from(head)
        if major != 1 or minor > 5:
            raise Damaged(f"it says version {major}.{minor}; 1.0 to 1.5 are known")
        if not max(end, _SMALLEST) <= start <= size:
            raise Damaged(f"its points begin at byte {start}; its header has {end} and the file {size}")
        check_room("records", n_records, _RECORD_BYTES, start - end)
        if minor >= 4:
            first, n_extended, n_points = _EXTENDED.unpack(head.ljust(_EXTENDED.size))
            _check_extended(file, first, n_extended, size)
    if kind & _COMPRESSION != _COMPRESSED:
        check_room("points", n_points, length, size - start)


def largest_chunk(path: Path, header: laspy.LasHeader) -> int:
    """Points in the largest chunk of a LAZ, as far as its table says; 0 without a table.

    Raises
    ------
    Damaged
        The chunks are not in the file, or hold fewer points than promised.
    """
    records = header.vlrs.get("LasZipVlr")
    if not records:
        raise Damaged("it has no record that says how its points are compressed")
    how = records[0].record_data_bytes()
    if how[:2] == _POINTWISE:
        return 0
    start, size = header.offset_to_point_data, path.stat().st_size
    with path.open("rb") as file:
        table = _table_position(file, start, size)
        file.seek(table + 4)
        check_room("chunks", int.from_bytes(file.read(4), "little"), header.point_format.size, size - start)
        file.seek(start)
        chunks = read_chunk_table(file, LazVlr(how))
        check_held("bytes of points", sum(n_bytes for _, n_bytes in chunks), table - start)
        if how[:2] == _LAYERED:
            _check_layers(file, how, start + 8, [n_bytes for _, n_bytes in chunks if n_bytes])
    check_held("points", header.point_count, sum(n_points for n_points, _ in chunks))
    return max((n_points for n_points, _ in chunks), default=0)


def _table_position(file: BinaryIO, start: int, size: int) -> int:
    """Where the table of chunks begins; a writer that could not go back says so in the last bytes."""
    for at in (start, size - 8):
        file.seek(max(at, 0))
        position = int.from_bytes(file.read(8), "little", signed=True)
        if position > start:
            break
    if not start < position <= size - 8:
        raise Damaged(f"its table of chunks begins at byte {position}, not between {start} and {size}")
    return position


def _check_layers(file: BinaryIO, how: bytes, start: int, chunks: list[int]) -> None:
    """In front of each chunk, after its first point and a count, stand the lengths of its layers."""
    starts = range(_FIRST_ITEM_AT, len(how) - _ITEM.size + 1, _ITEM.size)
    items: list[tuple[int, int]] = [_ITEM.unpack_from(how, at) for at in starts]
    before = sum(length for _, length in items) + 4
    n_layers = sum(_LAYERS.get(kind) or length for kind, length in items)
    for n_bytes in chunks:
        file.seek(start + before)
        lengths = np.frombuffer(file.read(4 * n_layers), "<u4")
        check_held("bytes of layers", int(lengths.sum()), n_bytes - before - 4 * n_layers)
        start += n_bytes


def _check_extended(file: BinaryIO, start: int, count: int, size: int) -> None:
    """Each extended record, by its length, ends inside the file."""
    if count:
        check_room("extended records", count, _EXTENDED_RECORD.size, size - start)
    for _ in range(count):
        file.seek(start)
        start += _EXTENDED_RECORD.size + _EXTENDED_RECORD.unpack(file.read(_EXTENDED_RECORD.size))[2]
        if start > size:
            raise Damaged(f"an extended record would end at byte {start} of {size}")
