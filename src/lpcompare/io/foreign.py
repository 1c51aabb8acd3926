"""The other formats that MeshLab reads, through pymeshlab; they cannot be written.

Files that MeshLab would read in part, or fill up, without a word, or that would take all memory, are refused
before it reads them; so are those that name a file outside their folder.
"""

from __future__ import annotations

import json
import re
import struct
import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from lpcompare.io import e57
from lpcompare.io.columns import AXES, COLORS, NORMALS, cloud_of
from lpcompare.io.rows import Damaged, check_held
from lpcompare.mesh_library import pymeshlab
from lpcompare.types import PointCloud

_CTM = struct.Struct("<12x6I")  # vertices, triangles, texture and attribute maps, flags, length of comment
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
_NAMING = (".dae", ".glb", ".gltf", ".wrl", ".x3d", ".x3dv")
_REFERENCE = re.compile(
    rb"""(?:\b(?:uri|url)\b["']?\s*[=:]?|<init_from>)[\s"'\[]*([^"'<>\]\s][^"'<>\]]*)""",
    re.IGNORECASE,
)
_HARMLESS = re.compile(r"#|data:|https?:|urn:|.*\.(png|jpe?g|bmp|tga|tiff?|gif|dds)$", re.IGNORECASE)


def read(path: Path) -> PointCloud:
    """All layers of the file as one cloud, each in its place; polygons as triangles.

    Normals are taken from files without faces only: of a mesh, MeshLab computes them anew. What a layer does
    not have and another has is NaN.
    """
    check_length(path)
    _check_references(path)
    layers = pymeshlab().MeshSet()
    _load(layers, path.resolve())
    meshes = [layers.mesh(i) for i in range(layers.mesh_number())]
    with_faces = any(mesh.face_number() for mesh in meshes)
    parts = [_columns(mesh, with_normals=not with_faces) for mesh in meshes]
    beside: list[str] = []
    if path.suffix.lower() == ".e57":
        found = e57.scans(path)
        beside = e57.left_out(found, sum(len(part["x"]) for part in parts))
        parts = _without_made_colors(parts, found)
    sizes = [len(part["x"]) for part in parts]
    columns = {
        name: np.concatenate([p.get(name, np.full(n, np.nan)) for p, n in zip(parts, sizes, strict=True)])
        for name in dict.fromkeys(name for part in parts for name in part)
    }
    starts = np.cumsum([0, *sizes])
    faces = np.concatenate([mesh.face_matrix() + start for mesh, start in zip(meshes, starts, strict=False)])
    return cloud_of(columns, path.stem, faces.astype(np.intp) if with_faces else None, beside)


def _without_made_colors(
    parts: list[dict[str, NDArray[np.float64]]], scans: list[e57.Scan]
) -> list[dict[str, NDArray[np.float64]]]:
    """The columns of the layers of an E57 with the colors that it has."""
    if len(parts) != len(scans):
        raise Damaged(f"MeshLab reads {len(parts)} of its {len(scans)} scans")
    return [
        part if scan.has_colors else {name: v for name, v in part.items() if name not in COLORS}
        for part, scan in zip(parts, scans, strict=True)
    ]


def _load(layers: Any, path: Path) -> None:
    try:
        str(path).encode()
    except UnicodeEncodeError:  # a name that MeshLab cannot spell
        with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
            link = Path(folder) / f"cloud{path.suffix}"
            link.symlink_to(path)
            layers.load_new_mesh(str(link))
        return
    layers.load_new_mesh(str(path))


def _columns(mesh: Any, *, with_normals: bool) -> dict[str, NDArray[np.float64]]:
    columns = dict(zip(AXES, mesh.transformed_vertex_matrix().T, strict=True))
    normals = mesh.vertex_normal_matrix() @ mesh.transform_matrix()[:3, :3].T
    if with_normals and normals.any():
        columns |= dict(zip(NORMALS, normals.T, strict=True))
    if mesh.has_vertex_color():
        columns |= dict(zip(COLORS, mesh.vertex_color_matrix().T, strict=True))
    if mesh.has_vertex_scalar():
        columns["quality"] = mesh.vertex_scalar_array()
    return columns


def _check_references(path: Path) -> None:
    """Raise `Damaged` where the file names one outside its folder."""
    if path.suffix.lower() not in _NAMING:
        return
    content = path.read_bytes()
    if path.suffix.lower() == ".glb":
        content = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    folder = path.resolve().parent
    if path.suffix.lower() in (".glb", ".gltf"):
        names = [part.get("uri", "") for part in _dictionaries(content)]
    else:
        names = [name.decode(errors="replace").strip() for name in _REFERENCE.findall(content)]
    for name in names:
        named = unquote(name.removeprefix("file://").replace("\\", "/"))
        if not _HARMLESS.match(name) and not (folder / named).resolve().is_relative_to(folder):
            raise Damaged(f"it names the file {name[:80]!r}, which is outside its folder")


def _dictionaries(content: bytes) -> list[dict[str, Any]]:
    """Buffers and images of a glTF."""
    try:
        document = json.loads(content.rstrip(b"\0 "))
        parts = [part for key in ("buffers", "images") for part in document.get(key, [])]
    except (ValueError, AttributeError, TypeError, RecursionError):
        raise Damaged("its JSON is damaged") from None
    return [part for part in parts if isinstance(part, dict) and isinstance(part.get("uri", ""), str)]


def check_length(path: Path) -> None:
    """Raise a `Damaged` where the file is not as long as it says."""
    content = path.read_bytes()
    suffix = path.suffix.lower()
    if content.startswith(b"[Expe"):
        _check_expe(content)
    elif suffix in _CHECKS:
        _CHECKS[suffix](content)


def _check_3ds(content: bytes) -> None:
    promised = int.from_bytes(content[2:6], "little")
    if promised != len(content):
        raise Damaged(f"it promises {promised} bytes and holds {len(content)}")


def _check_stl(content: bytes) -> None:
    if b"facet" in content[:1024] and b"endsolid" not in content[-1024:]:
        raise Damaged("it ends before 'endsolid'")


def _check_ctm(content: bytes) -> None:
    if not content.startswith(b"OCTM") or len(content) < _CTM.size:
        raise Damaged(f"it begins with {content[:4]!r}, not with b'OCTM', or ends in its header")
    vertices, triangles, textures, attributes, _, comment = _CTM.unpack_from(content)
    check_held("bytes of comment", comment, len(content) - _CTM.size)
    check_held("maps", textures + attributes, len(content) // _SMALLEST_MAP)
    room = len(content) * _LARGEST_SHARE
    check_held("vertices", vertices, room // _VERTEX_BYTES)
    check_held("triangles", triangles, room // _TRIANGLE_BYTES)


def _check_tri(content: bytes) -> None:
    if content[:2] not in _TRI or len(content) < _TRI_HEADER:
        raise Damaged(f"it begins with {content[:2]!r}, not with a byte order, or ends in its header")
    vertices, triangles = struct.unpack_from(_TRI[content[:2]], content, 2)
    if min(vertices, triangles) < 0:
        raise Damaged(f"it promises {vertices} vertices and {triangles} triangles")
    room = len(content) - _TRI_HEADER
    check_held("vertices", vertices, room // _VERTEX_BYTES)
    check_held("triangles", triangles, room // _TRIANGLE_BYTES - vertices)


def _check_expe(content: bytes) -> None:
    """MeshLab looks for 'data' for ever, and writes rows of text past the end of the points they are for."""
    head = _EXPE.match(content)
    if not head:
        raise Damaged("its header is not made of 'nofpoints' and 'property', then 'data'")
    words, body = (head[2] or head[3]) + b"\n", content[head.end() :]
    sizes = [int(n) * int(bits or 8) // 8 for n, bits in _EXPE_PROPERTY.findall(words)]
    counts = re.findall(rb"nofpoints\s+(\d+)\s", words)
    if not sum(sizes) or len(counts) != 1:
        raise Damaged("its header has no 'property' or not one 'nofpoints'")
    if head[1] == b"Binary":
        held = len(body) // sum(sizes)
    else:
        held = sum(line.count(b";") == len(sizes) - 1 for line in body.splitlines() if line.strip())
        if held > int(counts[0]):
            raise Damaged(f"it has {held} rows for {int(counts[0])} points")
    check_held("points", int(counts[0]), held)


_CHECKS = {
    ".3ds": _check_3ds,
    ".stl": _check_stl,
    ".ctm": _check_ctm,
    ".tri": _check_tri,
    ".apts": _check_expe,
}
