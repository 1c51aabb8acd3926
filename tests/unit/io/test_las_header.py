"""LAS files whose header promises what the file does not hold are refused before laspy makes room for it."""

import struct
from pathlib import Path

import laspy
import lazrs
import numpy as np
import pytest

from lpcompare.errors import InputError
from lpcompare.io import las, read

N = 60
BILLION = struct.pack("<I", 10**9)


@pytest.fixture
def points():
    return np.random.default_rng(8).normal(size=(N, 3))


def made(path: Path, points, version="1.4", kind=7):
    file = laspy.LasData(laspy.LasHeader(version=version, point_format=kind))
    file.x, file.y, file.z = points.T
    if version == "1.4":
        file.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("lab", 7, "a note", b"12345")])
    file.write(str(path))
    return path


def overwritten(path: Path, at, new):
    content = bytearray(path.read_bytes())
    content[at : at + len(new)] = new
    path.write_bytes(content)
    return path


def number(path: Path, kind, at):
    return struct.unpack_from(kind, path.read_bytes(), at)[0]


@pytest.mark.parametrize(
    ("at", "new", "reason"),
    [
        (0, b"PLY", r"it begins with b'PLYF', not with b'LASF'"),
        (25, b"\x09", "it says version 1.9; 1.0 to 1.5 are known"),
        (96, b"\1\0\0\0", "its points begin at byte 1; its header has 375 and the file 2600"),
        (96, BILLION, "its points begin at byte 1000000000; its header has 375 and the file 2600"),
        (100, BILLION, "it promises 1000000000 records and holds 0"),
        (243, BILLION, "it promises 1000000000 extended records and holds 1"),
        (247, struct.pack("<Q", 2**40), "it promises 1099511627776 points and holds 61"),
    ],
)
def test_counts_that_the_file_has_no_room_for(at, new, reason, points, tmp_path):
    path = overwritten(made(tmp_path / "a.las", points), at, new)
    with pytest.raises(ValueError, match=reason):
        las.read(path)


def test_old_headers_are_held_against_the_file_too(points, tmp_path):
    path = overwritten(made(tmp_path / "a.las", points, "1.2", 0), 107, BILLION)
    with pytest.raises(ValueError, match="it promises 1000000000 points and holds 60"):
        las.read(path)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ValueError, match="it ends in the header, after 100 of at least 227 bytes"):
        las.read(path)


def test_an_extended_record_longer_than_the_file(points, tmp_path):
    path = made(tmp_path / "a.las", points)
    overwritten(path, number(path, "<Q", 235) + 20, struct.pack("<Q", 10**12))
    with pytest.raises(ValueError, match=r"an extended record would end at byte 100000000\d+ of 2600"):
        las.read(path)


def test_a_kind_of_points_that_is_neither_compressed_nor_plain(points, tmp_path):
    """Both bits are set, which laspy takes for plain."""
    path = overwritten(made(tmp_path / "a.las", points), 104, bytes([7 | 0xC0]))
    overwritten(path, 247, struct.pack("<Q", 2**40))
    with pytest.raises(ValueError, match="it promises 1099511627776 points"):
        las.read(path)


@pytest.mark.parametrize("new", [-1, 5, 10**9])
def test_a_table_of_chunks_that_is_not_in_the_file(new, points, tmp_path):
    path = made(tmp_path / "a.laz", points)
    overwritten(path, number(path, "<I", 96), struct.pack("<q", new))
    with pytest.raises(ValueError, match=r"its table of chunks begins at byte -?\d+, not between"):
        las.read(path)


def test_more_chunks_or_layers_than_the_file_has_bytes(points, tmp_path):
    path = made(tmp_path / "a.laz", points)
    start, content = number(path, "<I", 96), path.read_bytes()
    overwritten(path, number(path, "<q", start) + 4, BILLION)
    with pytest.raises(ValueError, match="it promises 1000000000 chunks and holds"):
        las.read(path)
    path.write_bytes(content)
    overwritten(path, start + 8 + 36 + 4, BILLION)
    with pytest.raises(ValueError, match=r"it promises 10000\d+ bytes of layers and holds"):
        las.read(path)


def test_more_points_than_the_chunks_hold(points, tmp_path):
    path = overwritten(made(tmp_path / "a.laz", points), 247, struct.pack("<Q", 10**9))
    with pytest.raises(ValueError, match="it promises 1000000000 points and holds 50000"):
        las.read(path)


def test_a_laz_without_its_record(points, tmp_path):
    path = made(tmp_path / "a.laz", points)
    path.write_bytes(path.read_bytes().replace(b"laszip encoded", b"laszip decoded"))
    with pytest.raises(ValueError, match="no record that says how its points are compressed"):
        las.read(path)


def test_a_chunk_with_room_for_more_points_than_there_are_takes_no_memory_for_them(points, tmp_path):
    path = made(tmp_path / "a.laz", points)
    path.write_bytes(path.read_bytes().replace(struct.pack("<I", 50000), struct.pack("<I", 2**31)))
    assert np.allclose(las.read(path).points, points, atol=0.01)


@pytest.mark.parametrize(("version", "kind"), [("1.1", 1), *(("1.4", kind) for kind in range(11))])
@pytest.mark.parametrize("n_points", [N, 120_000])
def test_every_kind_of_point_of_one_chunk_and_of_several(version, kind, n_points, tmp_path):
    rows = np.arange(0, n_points, 7)
    points = np.random.default_rng(8).normal(size=(n_points, 3))
    las.keep_rows(made(tmp_path / "a.laz", points, version, kind), tmp_path / "b.laz", rows)
    assert np.array_equal(las.read(tmp_path / "b.laz").points, las.read(tmp_path / "a.laz").points[rows])


def test_chunks_of_several_sizes(points, tmp_path, monkeypatch):
    """As a COPC has them."""
    new = lazrs.LazVlr.new_for_compression
    header = laspy.LasHeader(version="1.4", point_format=7)
    file = laspy.LasData(header)
    file.x, file.y, file.z = points.T
    varying = type("LazVlr", (), {"new_for_compression": staticmethod(lambda *kind: new(*kind, True))})
    monkeypatch.setattr("lazrs.LazVlr", varying)
    with laspy.open(tmp_path / "a.laz", mode="w", header=header, laz_backend=laspy.LazBackend.Lazrs) as out:
        for first in range(0, N, 20):
            out.write_points(file.points[first : first + 20])
            out.point_writer.compressor.finish_current_chunk()
    monkeypatch.undo()
    assert np.allclose(las.read(tmp_path / "a.laz").points, points, atol=0.01)


def test_names_in_other_alphabets_stay_as_they_are(points, tmp_path):
    path = overwritten(made(tmp_path / "a.las", points), 58, "Entfernungsmeßgerät".encode("latin-1"))
    las.keep_rows(path, tmp_path / "b.las", np.arange(5))
    assert (tmp_path / "b.las").read_bytes()[26:90] == path.read_bytes()[26:90]


def test_version_1_0_becomes_1_1(points, tmp_path):
    path = overwritten(made(tmp_path / "a.las", points, "1.1", 1), 25, b"\0")
    las.keep_rows(path, tmp_path / "b.las", np.arange(5))
    assert (tmp_path / "b.las").read_bytes()[24:26] == b"\1\1"
    assert np.array_equal(las.read(tmp_path / "b.las").points, las.read(path).points[:5])


def test_no_text_of_the_library_is_shown(points, tmp_path):
    path = overwritten(made(tmp_path / "a.las", points), 104, b"\x3f")
    with pytest.raises(
        InputError, match=r"a\.las cannot be read as LAS: it is damaged, or not of this format\."
    ):
        read(path)
