"""What an E57 says of its scans in its XML, beside what MeshLab makes of them (ASTM E2807).

MeshLab places each scan by its pose. It leaves out points that are marked as invalid, and fields that it does not
know, without a word, and gives a scan without colors gray ones of its intensity.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

from lpcompare.io.rows import Damaged

_HEADER = struct.Struct("<8s8x8xQQQ")  # mark, place and length of the XML, length of a page
_CHECKSUM = 4
_SCAN = re.compile(rb"<points\b[^>]*>.*?</points>", re.DOTALL)
_COUNT = re.compile(rb'<points\b[^>]*\brecordCount="(\d+)"')
_PROTOTYPE = re.compile(rb"<prototype\b[^>]*>(.*?)</prototype>", re.DOTALL)
_FIELD = re.compile(rb"<([A-Za-z_][\w:.-]*)[\s/>]")
_KNOWN = re.compile(
    r"cartesian|spherical|color(Red|Green|Blue)$|intensity$|isIntensityInvalid$|isColorInvalid$"
)


@dataclass(frozen=True)
class Scan:
    """Points and fields that a scan promises."""

    n_points: int
    fields: tuple[str, ...]

    @property
    def has_colors(self) -> bool:
        """Whether the colors that MeshLab returns are of the file."""
        return "colorRed" in self.fields


def scans(path: Path) -> list[Scan]:
    """The scans of a file in its order; raises `Damaged` where it has no XML."""
    with path.open("rb") as file:
        header = file.read(_HEADER.size)
        if len(header) < _HEADER.size:
            raise Damaged("it ends within its header")
        mark, start, length, page = _HEADER.unpack(header)
        size = path.stat().st_size
        if mark != b"ASTM-E57" or not _CHECKSUM < page <= size or start + length > size:
            raise Damaged("its header is no header of an E57")
        begin = start % page
        file.seek(start - begin)
        n_pages = -(-(begin + length) // (page - _CHECKSUM))
        xml = b"".join(file.read(page)[:-_CHECKSUM] for _ in range(n_pages))[begin : begin + length]
    return [_scan(text) for text in _SCAN.findall(xml)]


def _scan(text: bytes) -> Scan:
    count, prototype = _COUNT.match(text), _PROTOTYPE.search(text)
    names = _FIELD.findall(prototype[1]) if prototype else []
    return Scan(int(count[1]) if count else 0, tuple(name.decode() for name in names))


def left_out(found: list[Scan], n_read: int) -> list[str]:
    """What MeshLab has left out of the scans of a file."""
    n_points = sum(scan.n_points for scan in found)
    lost = [f"{n_points - n_read:,} of {n_points:,} points (marked as invalid)"] if n_points > n_read else []
    names = dict.fromkeys(name for scan in found for name in scan.fields if not _KNOWN.match(name))
    return lost + [f"its field {name!r}" for name in names]
