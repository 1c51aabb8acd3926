"""Files that cannot be worked on: one sentence that names the file, and nothing written."""

import os
import random
import shutil

import numpy as np
import pytest

from lpcompare.errors import InputError
from lpcompare.io import keep_rows, read, write
from lpcompare.types import PointCloud

FORMATS = [".ply", ".obj", ".off", ".xyz", ".csv", ".npy", ".npz", ".pcd", ".las", ".laz"]
BINARY = [".ply", ".npy", ".npz", ".pcd", ".las", ".laz"]


@pytest.fixture(scope="module")
def cloud():
    rng = np.random.default_rng(2)
    return PointCloud(
        rng.normal(size=(300, 3)),
        colors=rng.integers(0, 256, (300, 4)) / 255,
        attributes={"label": rng.integers(0, 9, 300).astype(np.uint8)},
    )


def refused(path):
    with pytest.raises(InputError) as caught:
        read(path)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert sentence.endswith((".", "?"))
    assert path.name in sentence
    return sentence


@pytest.mark.parametrize("suffix", FORMATS)
def test_missing_and_empty_files_and_folders(suffix, tmp_path):
    path = tmp_path / f"a{suffix}"
    assert "No such file" in refused(path)
    path.touch()
    assert "empty" in refused(path)
    path.unlink()
    path.mkdir()
    assert "folder" in refused(path)


@pytest.mark.parametrize("suffix", BINARY)
@pytest.mark.parametrize("share", [0.05, 0.5, 0.97])
def test_truncated_files(suffix, share, cloud, tmp_path):
    path = tmp_path / f"a{suffix}"
    write(path, cloud)
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
    refused(path)


def test_ascii_ply_and_counted_text_that_are_too_short(tmp_path):
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    head = f"ply\nformat ascii 1.0\nelement vertex 3\n{axes}end_header\n"
    (tmp_path / "a.ply").write_text(head + "0 0 0\n1 1 1\n")
    assert "it promises 3 rows of 'vertex' and holds 2" in refused(tmp_path / "a.ply")
    (tmp_path / "a.pts").write_text("3\n0 0 0\n1 1 1\n")
    assert "promises 3 points and holds 2" in refused(tmp_path / "a.pts")
    (tmp_path / "a.off").write_text("OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n")
    assert "promises 3 vertices and 1 faces" in refused(tmp_path / "a.off")


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("other", [".ply", ".npz", ".laz"])
def test_mislabelled_files(suffix, other, cloud, tmp_path):
    same_family = {suffix, other} in ({".npy", ".npz"}, {".las", ".laz"})
    if suffix == other or same_family:
        return
    write(tmp_path / f"a{other}", cloud)
    shutil.copy(tmp_path / f"a{other}", tmp_path / f"b{suffix}")
    refused(tmp_path / f"b{suffix}")


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".xyz", ".csv", ".npy", ".npz", ".pcd"])
def test_rows_that_are_not_finite_are_kept_or_left_out_as_asked(suffix, cloud, tmp_path):
    points = cloud.points.copy()
    points[[4, 17], 1] = np.nan, np.inf
    assert write(tmp_path / f"a{suffix}", PointCloud(points)) == ()
    assert np.array_equal(read(tmp_path / f"a{suffix}").points, points, equal_nan=True)
    kept = read(tmp_path / f"a{suffix}", drop_invalid=True)
    assert np.array_equal(kept.points, np.delete(points, [4, 17], axis=0))


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_las_refuses_coordinates_that_are_no_numbers(suffix, tmp_path):
    with pytest.raises(InputError, match="NaN or infinite, which LAS cannot hold"):
        write(tmp_path / f"a{suffix}", PointCloud(np.array([[0, 0, np.nan]])))
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", FORMATS)
def test_one_point_is_a_cloud(suffix, tmp_path):
    write(tmp_path / f"a{suffix}", PointCloud(np.array([[1.0, 2.0, 3.0]])))
    assert read(tmp_path / f"a{suffix}").points.tolist() == [[1, 2, 3]]
    keep_rows(tmp_path / f"a{suffix}", tmp_path / f"b{suffix}", np.array([0]))
    assert len(read(tmp_path / f"b{suffix}")) == 1


def test_unknown_endings_are_answered_with_the_known_ones(cloud, tmp_path):
    (tmp_path / "a.docx").write_text("x")
    assert ".ply" in refused(tmp_path / "a.docx")
    with pytest.raises(InputError, match="cannot be written"):
        write(tmp_path / "a.stl", cloud)


def test_decimal_commas_are_not_taken_for_separators(tmp_path):
    (tmp_path / "a.txt").write_text("1,5 2,5 3,5\n")
    assert "decimal commas" in refused(tmp_path / "a.txt")
    (tmp_path / "a.csv").write_text("1,5;2,5;3,5\n")
    assert "decimal commas" in refused(tmp_path / "a.csv")


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".laz", ".csv"])
@pytest.mark.parametrize("values", [np.array(["a", "b"]), np.array([1j, 2j]), np.array([[1], []], object)])
def test_attributes_that_are_no_real_numbers_are_left_out_and_named(suffix, values, tmp_path):
    cloud = PointCloud(np.eye(3)[:2], attributes={"kind": values})
    (note,) = write(tmp_path / f"a{suffix}", cloud)
    assert note.startswith("attribute 'kind' is left out")
    assert "kind" not in read(tmp_path / f"a{suffix}").attributes


@pytest.mark.parametrize("name", ["vertex", "face"])
def test_a_ply_that_promises_billions_of_rows(name, tmp_path):
    """Its reader would make room for them first, and then look for them."""
    mesh = PointCloud(np.eye(3), faces=np.array([[0, 1, 2]]))
    write(tmp_path / "a.ply", mesh)
    content = (tmp_path / "a.ply").read_bytes()
    count = {"vertex": b"vertex 3", "face": b"face 1"}[name]
    (tmp_path / "a.ply").write_bytes(content.replace(count, count[:-1] + b"1000000000"))
    size = (tmp_path / "a.ply").stat().st_size
    sentence = refused(tmp_path / "a.ply")
    assert f"it promises 1000000000 rows of '{name}' and holds {size} bytes" in sentence


def test_faces_that_name_no_point(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n")
    assert "a face names point 3" in refused(tmp_path / "a.obj")


def test_a_pcd_with_more_values_a_point_than_anyone_stores(tmp_path):
    """Its reader would name every one of them, until the memory is full."""
    write(tmp_path / "a.pcd", PointCloud(np.zeros((2, 3)), attributes={"t": np.zeros(2)}))
    content = (tmp_path / "a.pcd").read_bytes()
    (tmp_path / "a.pcd").write_bytes(content.replace(b"COUNT 1 1 1 1", b"COUNT 1 1 1 9999999999"))
    assert "it has more than 9999 fields, or values of one field" in refused(tmp_path / "a.pcd")


def test_nothing_is_left_of_a_failed_write(cloud, tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        write(tmp_path / "nowhere" / "a.ply", cloud)
    os.mkfifo(tmp_path / "pipe.ply")
    with pytest.raises(InputError, match="not a file"):
        write(tmp_path / "pipe.ply", cloud)
    (tmp_path / "pipe.ply").unlink()
    (tmp_path / "a.las").write_text("precious")
    with pytest.raises(InputError, match="cannot be written: coordinates are NaN"):
        write(tmp_path / "a.las", PointCloud(np.full((2, 3), np.nan)))
    assert [p.read_text() for p in tmp_path.iterdir()] == ["precious"]


@pytest.mark.parametrize("suffix", FORMATS)
def test_damaged_files_are_read_or_refused(suffix, cloud, tmp_path):
    """Seeded mutations, few of those that cost a child process."""
    path = tmp_path / f"a{suffix}"
    write(path, PointCloud(cloud.points[:40], colors=cloud.colors[:40]))
    content, chance, sentences = path.read_bytes(), random.Random(5), []
    for _ in range(4 if suffix in (".las", ".laz") else 150):
        path.write_bytes(mutated(content, chance))
        try:
            assert read(path).points.shape[1] == 3
        except InputError as error:
            sentences.append(str(error))
    assert not any("\n" in sentence for sentence in sentences)


def mutated(content, chance):
    """Bytes changed, cut out, doubled or cut off."""
    data = bytearray(content)
    for _ in range(chance.randint(1, 8)):
        at = chance.randrange(len(data)) if data else 0
        kind = chance.randrange(4)
        if kind == 0 and data:
            data[at] = chance.randrange(256)
        elif kind == 1:
            del data[at : at + chance.randint(1, 16)]
        elif kind == 2:
            data[at:at] = data[at : at + chance.randint(1, 16)]
        elif chance.random() < 0.2:
            del data[at:]
    return bytes(data)


@pytest.mark.parametrize("suffix", [".3ds", ".stl", ".dae", ".x3d", ".wrl", ".e57"])
def test_half_of_a_file_of_meshlab_is_refused(suffix, cloud, tmp_path):
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(cloud.points, np.arange(300).reshape(100, 3)))
    path = tmp_path / f"a{suffix}"
    layers.save_current_mesh(str(path))
    assert len(read(path)) == 300
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    refused(path)


def test_half_of_an_ascii_stl_is_refused(cloud, tmp_path):
    corner = "outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "a.stl").write_text("solid a\n" + f"facet normal 0 0 1\n{corner}" * 2)
    assert "endsolid" in refused(tmp_path / "a.stl")


def test_grids_and_words_are_not_taken_for_points(tmp_path):
    (tmp_path / "a.asc").write_text("ncols 3\nnrows 2\n1 2 3\n4 5 6\n")
    assert "line 2 is b'nrows 2'" in refused(tmp_path / "a.asc")
    (tmp_path / "a.txt").write_text("x y z\n1 2 3\nend\n")
    assert "line 3 is b'end'" in refused(tmp_path / "a.txt")


def test_a_file_that_is_no_array_is_not_taken_for_a_pickle(tmp_path):
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPX\1\0" + bytes(200))
    assert "begins neither as an array of NumPy" in refused(tmp_path / "a.npy")


def test_rows_of_several_widths_stay_readable_when_the_first_ones_go(tmp_path):
    colored = "".join(f"v {i} 0 0 0.1 0.2 0.3\n" for i in range(3))
    (tmp_path / "a.obj").write_text(f"v 9 9 9\n{colored}v 5 5 5\n")
    before = read(tmp_path / "a.obj")
    keep_rows(tmp_path / "a.obj", tmp_path / "b.obj", np.array([1, 4]))
    assert np.array_equal(read(tmp_path / "b.obj").points, before.points[[1, 4]])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.pts", "1_0\n" + "1 2 3\n" * 10),
        (
            "a.pcd",
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1_0\nHEIGHT 1\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1_0\nDATA ascii\n" + "1 2 3\n" * 10,
        ),
    ],
)
def test_counts_as_python_reads_them_are_counted_anew(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    keep_rows(tmp_path / name, tmp_path / f"b{name}", np.array([1, 2]))
    assert len(read(tmp_path / f"b{name}")) == 2
