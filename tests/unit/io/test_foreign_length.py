"""What MeshLab would fill up with rubbish, or would take the memory for, is refused before it reads."""

import struct

import numpy as np
import pytest

from lpcompare.io.foreign import check_length

N = 12


def expe(version, properties, body):
    return f"[Expe/PointSet/{version}]\nnofpoints {N}\n{properties}data\n".encode() + body


ROW = np.arange(6, dtype="<f4").tobytes() + b"\1\2\3\xff"
PROPERTIES = "property position 3 r32\nproperty normal 3 r32\nproperty color 4 ui8\n"
FILES = {
    "binary.apts": expe("Binary/0.2", PROPERTIES, ROW * N),
    "binary.pts": expe("Binary/0.2", PROPERTIES, ROW * N),
    "old.apts": expe("Binary/0.1", "property position 12\nproperty normal 12\nproperty color 4\n", ROW * N),
    "text.apts": expe("Ascii/0.2", "property position 3 r32\nproperty radius 1 r32\n", b"(1, 2, 3);4\n" * N),
    "little.tri": b"LE" + struct.pack("<3i", N, 2, 0) + bytes(12 * (N + 2)),
    "big.tri": b"BE" + struct.pack(">3i", N, 2, 0) + bytes(12 * (N + 2)),
}


@pytest.mark.parametrize("name", FILES)
def test_whole_files_pass_and_shorter_ones_are_refused(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(FILES[name])
    check_length(path)
    for share in (0.95, 0.5):
        path.write_bytes(FILES[name][: int(len(FILES[name]) * share)])
        with pytest.raises(ValueError, match=r"it promises \d+ (points|vertices|triangles) and holds \d+"):
            check_length(path)
    path.write_bytes(FILES[name][:10])
    with pytest.raises(ValueError, match="header"):
        check_length(path)


@pytest.mark.parametrize("words", [b"dada\n", b"property more 3 data\n", b"property 3\ndata\n"])
def test_an_expe_file_in_which_meshlab_would_look_for_data_for_ever(words, tmp_path):
    (tmp_path / "a.apts").write_bytes(FILES["binary.apts"].replace(b"data\n", words))
    with pytest.raises(ValueError, match="then 'data'"):
        check_length(tmp_path / "a.apts")


def test_an_expe_file_with_more_rows_than_points(tmp_path):
    """MeshLab would write them into memory that is not its own."""
    (tmp_path / "a.apts").write_bytes(FILES["text.apts"] + b"(1, 2, 3);4\n")
    with pytest.raises(ValueError, match="it has 13 rows for 12 points"):
        check_length(tmp_path / "a.apts")


def test_negative_counts_of_a_tri(tmp_path):
    (tmp_path / "a.tri").write_bytes(b"LE" + struct.pack("<3i", -5, 2, 0) + bytes(500))
    with pytest.raises(ValueError, match="it promises -5 vertices and 2 triangles"):
        check_length(tmp_path / "a.tri")


@pytest.mark.parametrize(
    ("at", "what"),
    [(12, "vertices"), (16, "triangles"), (20, "maps"), (24, "maps"), (32, "bytes of comment")],
)
def test_a_ctm_that_promises_billions(at, what, tmp_path):
    pymeshlab = pytest.importorskip("pymeshlab")
    path = tmp_path / "a.ctm"
    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(np.random.default_rng(1).normal(size=(N, 3)), np.array([[0, 1, 2]])))
    layers.save_current_mesh(str(path))
    check_length(path)
    content = bytearray(path.read_bytes())
    content[at : at + 4] = struct.pack("<I", 3 * 10**9)
    path.write_bytes(content)
    with pytest.raises(ValueError, match=rf"it promises 300000000\d {what} and holds \d+"):
        check_length(path)
    path.write_bytes(b"OCT")
    with pytest.raises(ValueError, match="or ends in its header"):
        check_length(path)
