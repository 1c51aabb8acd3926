"""What a LAS file promises, held against its size before laspy believes it.

laspy makes an object for every promised record and a byte for every promised byte of points, found or not.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import BinaryIO

import laspy
import numpy as np
from lazrs.lazrs import LazVlr, read_chunk_table

from lpcompare.io.checks import check_held

_FIRST = struct.Struct("<24xBB68xHIIBHI")  # version, sizes and counts, the same in every version
_EXTENDED = struct.Struct("<235xQIQ")  # the additions of version 1.4
_SMALLEST = 227
_RECORD_BYTES = 54
_EXTENDED_RECORD_BYTES = 60
_LENGTH_AT = 20
_COMPRESSED, _COMPRESSION = 0x80, 0xC0
_POINTWISE, _LAYERED = b"\1\0", b"\3\0"
_ITEM = struct.Struct("<HH2x")  # a part of a compressed point: kind, bytes, version
_FIRST_ITEM_AT = 34
_LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}  # of the kinds of part; extra bytes have a layer each


def check_header(path: Path) -> None:
    """Raise a `ValueError` where records, or points that are not compressed, need more than the file."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_EXTENDED.size)
        if not head.startswith(b"LASF"):
            raise ValueError(f"it begins with {head[:4]!r}, not with b'LASF'")
        if len(head) < _SMALLEST:
            raise ValueError(f"it ends in the header, after {len(head)} of at least {_SMALLEST} bytes")
        major, minor, end, start, n_records, kind, length, n_points = _FIRST.unpack_from(head)
        if major != 1 or minor > 5:
            raise ValueError(f"it says version {major}.{minor}; 1.0 to 1.5 are known")
        if not max(end, _SMALLEST) <= start <= size:
            raise ValueError(f"its points begin at byte {start}; its header has {end} and the file {size}")
        _check_room("records", n_records, _RECORD_BYTES, start - end)
        if minor >= 4:
            first, n_extended, n_points = _EXTENDED.unpack(head.ljust(_EXTENDED.size))
            _check_extended(file, first, n_extended, size)
    if kind & _COMPRESSION != _COMPRESSED:
        _check_room("points", n_points, length, size - start)


def largest_chunk(path: Path, header: laspy.LasHeader) -> int:
    """Points in the largest chunk of a LAZ, as far as its table says; 0 without a table.

    Raises
    ------
    ValueError
        The chunks are not in the file, or hold fewer points than promised.
    """
    records = header.vlrs.get("LasZipVlr")
    if not records:
        raise ValueError("it has no record that says how its points are compressed")
    how = records[0].record_data_bytes()
    if how[:2] == _POINTWISE:
        return 0
    start, size = header.offset_to_point_data, path.stat().st_size
    with path.open("rb") as file:
        table = _table_position(file, start, size)
        file.seek(table + 4)
        _check_room("chunks", int.from_bytes(file.read(4), "little"), header.point_format.size, size - start)
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
        raise ValueError(f"its table of chunks begins at byte {position}, not between {start} and {size}")
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
        _check_room("extended records", count, _EXTENDED_RECORD_BYTES, size - start)
    for _ in range(count):
        file.seek(start + _LENGTH_AT)
        start += _EXTENDED_RECORD_BYTES + int.from_bytes(file.read(8), "little")
        if start > size:
            raise ValueError(f"an extended record would end at byte {start} of {size}")


def _check_room(what: str, promised: int, length: int, room: int) -> None:
    check_held(what, promised, room // length if length else 0)
