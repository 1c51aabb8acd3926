"""Files that MeshLab would read in part, or fill up, without a word; or that would take all memory."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from lpcompare.io.checks import check_held

_CTM = struct.Struct(
    "<12x6I"
)  # vertices, triangles, texture and attribute maps, flags, length of the comment
_SMALLEST_MAP = 8
_VERTEX_BYTES = _TRIANGLE_BYTES = 12
_LARGEST_SHARE = 10_000  # LZMA makes nothing shorter than a seven-thousandth
_TRI = {b"LE": "<2i", b"EB": "<2i", b"EL": ">2i", b"BE": ">2i"}
_TRI_HEADER = 14
_EXPE = re.compile(
    rb"""\[Expe/PointSet/ (Ascii|Binary) /0\.
    (?: 1\] ((?: \s+ nofpoints \s+ \d+ | \s+ property \s+ \S+ \s+ \d+ )+)
      | 2\] ((?: \s+ nofpoints \s+ \d+ | \s+ property \s+ \S+ \s+ \d+ \s+ (?:ui|i|r)(?:8|16|32) )+) )
    \s+ data \s""",
    re.VERBOSE,
)
_EXPE_PROPERTY = re.compile(rb"property\s+\S+\s+(\d+)(?:\s+(?:ui|i|r)(8|16|32))?\s")


def check_length(path: Path) -> None:
    """Raise a `ValueError` where the file is not as long as it says."""
    content = path.read_bytes()
    suffix = path.suffix.lower()
    if content.startswith(b"[Expe"):
        _check_expe(content)
    elif suffix in _CHECKS:
        _CHECKS[suffix](content)


def _check_3ds(content: bytes) -> None:
    promised = int.from_bytes(content[2:6], "little")
    if promised != len(content):
        raise ValueError(f"it promises {promised} bytes and holds {len(content)}")


def _check_stl(content: bytes) -> None:
    if b"facet" in content[:1024] and b"endsolid" not in content[-1024:]:
        raise ValueError("it ends before 'endsolid'")


def _check_ctm(content: bytes) -> None:
    if not content.startswith(b"OCTM") or len(content) < _CTM.size:
        raise ValueError(f"it begins with {content[:4]!r}, not with b'OCTM', or ends in its header")
    vertices, triangles, textures, attributes, _, comment = _CTM.unpack_from(content)
    check_held("bytes of comment", comment, len(content) - _CTM.size)
    check_held("maps", textures + attributes, len(content) // _SMALLEST_MAP)
    room = len(content) * _LARGEST_SHARE
    check_held("vertices", vertices, room // _VERTEX_BYTES)
    check_held("triangles", triangles, room // _TRIANGLE_BYTES)


def _check_tri(content: bytes) -> None:
    if content[:2] not in _TRI or len(content) < _TRI_HEADER:
        raise ValueError(f"it begins with {content[:2]!r}, not with a byte order, or ends in its header")
    vertices, triangles = struct.unpack_from(_TRI[content[:2]], content, 2)
    if min(vertices, triangles) < 0:
        raise ValueError(f"it promises {vertices} vertices and {triangles} triangles")
    room = len(content) - _TRI_HEADER
    check_held("vertices", vertices, room // _VERTEX_BYTES)
    check_held("triangles", triangles, room // _TRIANGLE_BYTES - vertices)


def _check_expe(content: bytes) -> None:
    """MeshLab looks for 'data' for ever, and writes rows of text past the end of the points they are for."""
    head = _EXPE.match(content)
    if not head:
        raise ValueError("its header is not made of 'nofpoints' and 'property', then 'data'")
    words, body = (head[2] or head[3]) + b"\n", content[head.end() :]
    sizes = [int(n) * int(bits or 8) // 8 for n, bits in _EXPE_PROPERTY.findall(words)]
    counts = re.findall(rb"nofpoints\s+(\d+)\s", words)
    if not sum(sizes) or len(counts) != 1:
        raise ValueError("its header has no 'property' or not one 'nofpoints'")
    if head[1] == b"Binary":
        held = len(body) // sum(sizes)
    else:
        held = sum(line.count(b";") == len(sizes) - 1 for line in body.splitlines() if line.strip())
        if held > int(counts[0]):
            raise ValueError(f"it has {held} rows for {int(counts[0])} points")
    check_held("points", int(counts[0]), held)


_CHECKS = {
    ".3ds": _check_3ds,
    ".stl": _check_stl,
    ".ctm": _check_ctm,
    ".tri": _check_tri,
    ".apts": _check_expe,
}
