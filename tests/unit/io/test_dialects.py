"""Headers that other tools write, bytes in any script, and normals and colours as the file means them."""

import json

import numpy as np
import pytest
from plyfile import PlyData

from lpcompare.errors import InputError
from lpcompare.io import keep_rows, read, write
from lpcompare.types import PointCloud

ROWS = "0 0 0\n1 0 0\n0 1 0\n"
TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
PCD = (
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    "WIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n"
)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\n"
    "property float x\nproperty float y\nproperty float z\nend_header\n"
)
FILES = {
    "version .5": ("a.pcd", PCD.replace("VERSION 0.7", "VERSION .5") + ROWS),
    "no version": ("a.pcd", PCD.replace("VERSION 0.7\n", "") + ROWS),
    "X Y Z": ("a.pcd", PCD.replace("x y z", "X Y Z") + ROWS),
    "padding of COUNT 0": (
        "a.pcd",
        PCD.replace("x y z", "x y z _")
        .replace("4 4 4", "4 4 4 1")
        .replace("F F F", "F F F U")
        .replace("1 1 1", "1 1 1 0")
        + ROWS,
    ),
    "no COUNT": ("a.pcd", PCD.replace("COUNT 1 1 1\n", "") + ROWS),
    "no WIDTH": ("a.pcd", PCD.replace("WIDTH 3\n", "").replace("HEIGHT 1\n", "") + ROWS),
    "COLUMNS": ("a.pcd", PCD.replace("FIELDS", "COLUMNS") + ROWS),
    "umlauts in a comment": ("a.pcd", "# Größe der Brücke\n" + PCD + ROWS),
    "line ends of Windows": ("a.pcd", (PCD + ROWS).replace("\n", "\r\n")),
    "PLY with X Y Z": (
        "a.ply",
        PLY.replace(" x\n", " X\n").replace(" y\n", " Y\n").replace(" z\n", " Z\n") + ROWS,
    ),
    "PLY with float32": ("a.ply", PLY.replace("float", "float32") + ROWS),
    "PLY with a comment in any script": (
        "a.ply",
        PLY.replace("element", "comment 橋の大きさ\nelement") + ROWS,
    ),
    "PLY, line ends of Windows": ("a.ply", (PLY + ROWS).replace("\n", "\r\n")),
    "PLY, line ends of the old Mac": ("a.ply", (PLY + ROWS).replace("\n", "\r")),
    "OFF in one line": ("a.off", "OFF 3 0 0\n" + ROWS),
    "OFF without its word": ("a.off", "3 0 0\n" + ROWS),
    "OFF without edges": ("a.off", "OFF\n3 0\n" + ROWS),
    "OFF with comments": ("a.off", "# Brücke\nOFF\n# more\n3 0 0\n" + ROWS),
    "OBJ with umlauts": ("a.obj", "# Brücke\no Größe\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"),
}


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize("name", FILES)
def test_headers_of_other_tools(name, encoding, tmp_path):
    file, text = FILES[name]
    content = text.encode(encoding, "ignore")
    (tmp_path / file).write_bytes(content)
    assert read(tmp_path / file).points.tolist() == TRIANGLE
    keep_rows(tmp_path / file, tmp_path / f"b{file}", np.array([0, 2]))
    assert read(tmp_path / f"b{file}").points.tolist() == [TRIANGLE[0], TRIANGLE[2]]


TWICE = {
    "a.ply": PLY.replace("end_header", "property float {}\nproperty float {}\nend_header")
    + "1 2 3 4 5\n" * 3,
    "a.pcd": PCD.replace("x y z", "x y z {} {}")
    .replace("4 4 4", "4 4 4 4 4")
    .replace("F F F", "F F F F F")
    .replace("1 1 1", "1 1 1 1 1")
    + "1 2 3 4 5\n" * 3,
    "a.csv": "x,y,z,{},{}\n1,2,3,4,5\n",
}


@pytest.mark.parametrize("name", TWICE)
def test_a_name_that_comes_twice_is_numbered_unless_it_is_a_coordinates(name, tmp_path):
    (tmp_path / name).write_text(TWICE[name].format("a", "a"))
    found = read(tmp_path / name).attributes
    assert (found["a"][0], found["a_2"][0]) == (4, 5)
    (tmp_path / name).write_text(TWICE[name].format("a", "y"))
    with pytest.raises(InputError, match="more than one column 'y'"):
        read(tmp_path / name)


def test_two_elements_of_one_name_are_refused(tmp_path):
    (tmp_path / "a.ply").write_text(
        PLY.replace("end_header", "element vertex 1\nproperty float a\nend_header")
    )
    with pytest.raises(InputError, match="more than one element 'vertex'"):
        read(tmp_path / "a.ply")


@pytest.mark.parametrize("name", ["a.ply", "a.off", "a.pcd", "a.pts"])
def test_text_with_more_rows_than_it_says_is_refused(name, tmp_path):
    head = {".ply": PLY, ".off": "OFF\n3 0 0\n", ".pcd": PCD, ".pts": "3\n"}[name[1:]]
    (tmp_path / name).write_text(head + ROWS + "9 9 9\n")
    with pytest.raises(InputError, match="holds 4"):
        read(tmp_path / name)


def test_rows_of_a_ply_of_text_stay_the_files_own(tmp_path):
    rows = ["512345.678 4123456.789 10.1\n", "512346.678   4123457.789 10.20\n", "1 2 3\n"]
    (tmp_path / "a.ply").write_text(PLY + "".join(rows))
    keep_rows(tmp_path / "a.ply", tmp_path / "b.ply", np.array([0, 1]))
    assert (tmp_path / "b.ply").read_text() == PLY.replace("vertex 3", "vertex 2") + rows[0] + rows[1]


def test_the_header_of_a_ply_stays_byte_for_byte(tmp_path):
    head = PLY.replace("ascii", "binary_big_endian").replace("element", "comment Größe\nobj_info ü\nelement")
    head = head.replace("float z", "float z\nproperty uchar label").encode("latin-1")
    table = np.zeros(3, ">f4, >f4, >f4, u1")
    table["f3"] = [7, 8, 9]
    (tmp_path / "a.ply").write_bytes(head + table.tobytes())
    keep_rows(tmp_path / "a.ply", tmp_path / "b.ply", np.array([1]))
    assert (tmp_path / "b.ply").read_bytes() == head.replace(b"vertex 3", b"vertex 1") + table[1:2].tobytes()


def test_a_field_of_several_values_is_an_attribute_of_several_columns(tmp_path):
    flow = np.arange(12, dtype="f4").reshape(4, 3)
    cloud = PointCloud(np.zeros((4, 3)), attributes={"flow": flow})
    assert write(tmp_path / "a.pcd", cloud) == ()
    assert np.array_equal(read(tmp_path / "a.pcd").attributes["flow"], flow)


def test_a_grid_becomes_a_list_and_this_is_said_once(tmp_path):
    (tmp_path / "a.pcd").write_text(PCD.replace("WIDTH 3\nHEIGHT 1", "WIDTH 1\nHEIGHT 3") + ROWS)
    notes = keep_rows(tmp_path / "a.pcd", tmp_path / "b.pcd", np.array([0, 1]))
    assert notes == ("the grid of 1 x 3 points becomes a list",)
    assert "WIDTH 2\nHEIGHT 1\nPOINTS 2\n" in (tmp_path / "b.pcd").read_text()
    assert keep_rows(tmp_path / "b.pcd", tmp_path / "c.pcd", np.array([0])) == ()


@pytest.mark.parametrize(
    ("faces", "normals"),
    [
        ("f 1//3 2//1 3//2\n", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        ("f 1//1 2//2 3//3\n", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ("f 1 2 3\n", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ("f 1//-1 2//-3 3//-2\n", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        ("f 1//1 2//2 3//3\nf 1//2 2//2 3//3\n", None),
        ("f 1//9 2//2 3//3\n", None),
    ],
)
def test_normals_of_an_obj_are_those_that_its_faces_name(faces, normals, tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nvn 0 1 0\nvn 0 0 1\n" + faces)
    cloud = read(tmp_path / "a.obj")
    assert (None if cloud.normals is None else cloud.normals.tolist()) == normals
    keep_rows(tmp_path / "a.obj", tmp_path / "b.obj", np.array([0, 2]))
    kept = read(tmp_path / "b.obj").normals
    assert (None if kept is None else kept.tolist()) == (normals and [normals[0], normals[2]])


COLORS = [[1, 0, 0, 1], [10 / 255, 20 / 255, 30 / 255, 1], [128 / 255, 128 / 255, 128 / 255, 1]]
NAMED = PLY.replace("float z", "float z\nproperty float red\nproperty float green\nproperty float blue")
COLORED = {
    "a.obj": "v 0 0 0 255 0 0\nv 1 0 0 10 20 30\nv 0 1 0 128 128 128\n",
    "a.ply": NAMED + "0 0 0 255 0 0\n1 0 0 10 20 30\n0 1 0 128 128 128\n",
    "b.ply": NAMED.replace("red", "diffuse_red")
    .replace("green", "diffuse_green")
    .replace("blue", "diffuse_blue")
    + "0 0 0 255 0 0\n1 0 0 10 20 30\n0 1 0 128 128 128\n",
    "c.ply": NAMED.replace("float red", "ushort red")
    .replace("float green", "ushort green")
    .replace("float blue", "ushort blue")
    + "0 0 0 65535 0 0\n1 0 0 2570 5140 7710\n0 1 0 32896 32896 32896\n",
    "a.off": "COFF\n3 0 0\n0 0 0 255 0 0 255\n1 0 0 10 20 30 255\n0 1 0 128 128 128 255\n",
    "b.off": "NCOFF\n3 0 0\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 10 20 30\n0 1 0 0 0 1 128 128 128\n",
    "a.csv": "x,y,z,red,green,blue\n0,0,0,255,0,0\n1,0,0,10,20,30\n0,1,0,128,128,128\n",
    "a.txt": "//X Y Z Rf Gf Bf\n0 0 0 1 0 0\n"
    "1 0 0 0.0392156862745098 0.0784313725490196 0.11764705882352941\n"
    "0 1 0 0.5019607843137255 0.5019607843137255 0.5019607843137255\n",
}


@pytest.mark.parametrize("name", COLORED)
def test_colours_of_any_scale_are_understood_over_the_whole_file(name, tmp_path):
    (tmp_path / name).write_text(COLORED[name])
    cloud = read(tmp_path / name)
    assert np.allclose(cloud.colors, COLORS, rtol=0, atol=1e-12)
    assert write(tmp_path / "out.ply", cloud) == ()
    table = PlyData.read(str(tmp_path / "out.ply"))["vertex"]
    assert {p.name: p.val_dtype for p in table.properties}["red"] == "u1"
    assert table["green"].tolist() == [0, 20, 128]


@pytest.mark.parametrize("kind", ["u1", "f8"])
@pytest.mark.parametrize("width", [3, 4])
def test_colours_of_an_npz_are_understood_on_any_scale(kind, width, tmp_path):
    bytes_ = np.array([[255, 0, 0, 255], [10, 20, 30, 255], [128, 128, 128, 255]], kind)[:, :width]
    np.savez(tmp_path / "a.npz", points=np.eye(3), colors=bytes_)
    assert np.allclose(read(tmp_path / "a.npz").colors, COLORS, rtol=0, atol=1e-12)


@pytest.mark.parametrize("suffix", [".ply", ".npz", ".csv", ".las"])
def test_colours_outside_0_to_1_are_cut_off_and_said(suffix, tmp_path):
    cloud = PointCloud(np.eye(3), colors=np.array([[255.0, 0, 0, 1], [-1, 0, 0, 1], [0.2, 0, 0, 1]]))
    assert "colors outside 0 to 1 are cut off" in write(tmp_path / f"a{suffix}", cloud)
    assert np.allclose(read(tmp_path / f"a{suffix}").colors[:, 0], [1, 0, 0.2])


@pytest.mark.parametrize(("corner", "kind"), [(0.5, "f8"), ("0", "U1"), (2**63, "u8")])
def test_faces_of_an_npz_that_are_no_rows_are_refused(corner, kind, tmp_path):
    np.savez(tmp_path / "a.npz", points=np.eye(3), faces=np.array([[corner, 1, 2]], kind))
    with pytest.raises(InputError, match="are no numbers of points"):
        read(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", "COFF\n2 0 0\n0 0 0 1 0 0 1\n1 0 0 0 1 1 0\n"),
        ("a.pts", "2\n0 0 0 -1 1 0 0\n1 0 0 -1 0 1 1\n"),
        (
            "a.ptx",
            "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0 1 0 .5 1 0 0\n1 0 0 .5 0 1 1\n",
        ),
    ],
)
def test_a_dark_cloud_is_not_taken_for_fractions(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    alpha = [[1 / 255], [0]] if name == "a.off" else [[1], [1]]
    colors = np.array([[1, 0, 0], [0, 1, 1]]) / 255
    assert np.array_equal(read(tmp_path / name).colors, np.column_stack([colors, alpha]))


def test_fractions_of_an_off_stay_fractions(tmp_path):
    (tmp_path / "a.off").write_text("COFF\n2 0 0\n0 0 0 1. 0 0 1\n1 0 0 0 1 1 0.5\n")
    assert read(tmp_path / "a.off").colors.tolist() == [[1, 0, 0, 1], [0, 1, 1, 0.5]]


def test_colours_a_little_over_one_are_fractions(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0 1.0000001 0 0\nv 1 0 0 0.5 0.5 0.5\n")
    assert read(tmp_path / "a.obj").colors[1, 0] == 0.5


def gltf(uri):
    """Two triangles, of which the first has colours, in a buffer elsewhere."""
    meshes = [{"POSITION": 0, "COLOR_0": 1}, {"POSITION": 0}]
    views = [(0, 36), (36, 48), (84, 6)]
    kinds = [(5126, "VEC3"), (5126, "VEC4"), (5123, "SCALAR")]
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [5, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": a, "indices": 2}]} for a in meshes],
            "buffers": [{"uri": uri, "byteLength": len(BUFFER)}],
            "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": n} for at, n in views],
            "accessors": [
                {"bufferView": i, "componentType": kind, "count": 3, "type": shape}
                for i, (kind, shape) in enumerate(kinds)
            ],
        }
    )


BUFFER = (
    np.array(TRIANGLE, "<f4").tobytes()
    + np.array([[1, 0, 0, 1]] * 3, "<f4").tobytes()
    + np.arange(4, dtype="<u2").tobytes()
)


def test_a_layer_without_what_another_has_is_nan_there(tmp_path):
    """MeshLab would fill in zeros."""
    pytest.importorskip("pymeshlab")
    (tmp_path / "b.bin").write_bytes(BUFFER)
    (tmp_path / "a.gltf").write_text(gltf("b.bin"))
    cloud = read(tmp_path / "a.gltf")
    assert cloud.points[:, 0].tolist() == [0, 1, 0, 5, 6, 5]
    assert np.array_equal(cloud.colors[:3], [[1, 0, 0, 1]] * 3)
    assert np.isnan(cloud.colors[3:]).all()
    assert cloud.faces.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert "colors of 3 points are not known" in " ".join(write(tmp_path / "a.ply", cloud))


@pytest.mark.parametrize(
    "uri", ["../b.bin", "%2e%2e/b.bin", "/etc/hostname", "file:///etc/hostname", "..\\b.bin"]
)
def test_no_file_outside_the_folder_is_followed(uri, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "b.bin").write_bytes(BUFFER)
    (tmp_path / "in" / "a.gltf").write_text(gltf(uri))
    with pytest.raises(InputError, match="which is outside its folder"):
        read(tmp_path / "in" / "a.gltf")
    (tmp_path / "in" / "a.x3d").write_text(f"<X3D><Scene><Inline url='\"{uri}\"'/></Scene></X3D>")
    with pytest.raises(InputError, match="which is outside its folder"):
        read(tmp_path / "in" / "a.x3d")
