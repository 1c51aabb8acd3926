"""Kept rows carry everything their format says; whole clouds survive a change of format."""

import struct

import laspy
import lzf
import numpy as np
import pypcd4
import pytest
from plyfile import PlyData, PlyElement

from lpcompare.errors import InputError
from lpcompare.io import keep_rows, read, write
from lpcompare.types import PointCloud

N = 200
ROWS = np.arange(0, N, 7)
UTM = np.array([512345.678, 4123456.789, 101.25])


@pytest.fixture
def rng():
    return np.random.default_rng(11)


@pytest.fixture
def cloud(rng):
    normals = rng.normal(size=(N, 3))
    return PointCloud(
        UTM + rng.normal(size=(N, 3)),
        normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
        colors=rng.integers(0, 256, (N, 4)) / 255,
        attributes={"intensity": rng.integers(0, 60000, N).astype(np.uint16), "height": rng.normal(size=N)},
        faces=rng.permuted(np.tile(np.arange(N), (50, 1)), axis=1)[:, :3],
        name="cloud",
    )


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".xyz", ".txt", ".csv", ".npy", ".npz", ".pcd"])
def test_coordinates_survive_to_the_last_bit(suffix, cloud, tmp_path):
    write(tmp_path / f"cloud{suffix}", cloud)
    assert np.array_equal(read(tmp_path / f"cloud{suffix}").points, cloud.points)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".npz"])
def test_faces_survive(suffix, cloud, tmp_path):
    write(tmp_path / f"cloud{suffix}", cloud)
    assert np.array_equal(read(tmp_path / f"cloud{suffix}").faces, cloud.faces)


def test_an_npy_says_that_it_holds_coordinates_and_unnamed_columns_only(cloud, tmp_path):
    assert write(tmp_path / "a.npy", cloud) == (
        ".npy holds no normals and no colors and no faces",
        "attribute 'intensity' is left out, .npy holds only columns",
        "attribute 'height' is left out, .npy holds only columns",
    )
    assert write(tmp_path / "a.npy", PointCloud(cloud.points, attributes={"columns": np.ones((N, 2))})) == ()


@pytest.mark.parametrize("suffix", [".ply", ".npz", ".pcd", ".txt", ".csv", ".las"])
def test_attributes_survive(suffix, cloud, tmp_path):
    write(tmp_path / f"cloud{suffix}", cloud)
    again = read(tmp_path / f"cloud{suffix}")
    for name, values in cloud.attributes.items():
        assert np.array_equal(again.attributes[name], values), name


@pytest.mark.parametrize("suffix", [".ply", ".npz", ".pcd", ".txt", ".las"])
@pytest.mark.parametrize("kind", [">f4", ">i4", "<u2", "?"])
def test_attributes_of_every_byte_order_survive(suffix, kind, tmp_path):
    values = np.array([0, 1, 1], dtype=kind)
    write(tmp_path / f"a{suffix}", PointCloud(np.eye(3), attributes={"v": values}))
    assert np.array_equal(read(tmp_path / f"a{suffix}").attributes["v"], values)


@pytest.mark.parametrize("suffix", [".ply", ".npz", ".pcd", ".las", ".obj", ".off"])
def test_colours_survive(suffix, cloud, tmp_path):
    write(tmp_path / f"cloud{suffix}", cloud)
    again = read(tmp_path / f"cloud{suffix}").colors
    alpha = slice(None) if suffix in (".ply", ".npz", ".pcd", ".off") else slice(3)
    assert np.allclose(again[:, alpha], cloud.colors[:, alpha], rtol=0, atol=1e-5)


@pytest.mark.parametrize("suffix", [".ply", ".npz", ".pcd", ".obj"])
def test_normals_survive(suffix, cloud, tmp_path):
    write(tmp_path / f"cloud{suffix}", cloud)
    assert np.allclose(read(tmp_path / f"cloud{suffix}").normals, cloud.normals, atol=1e-7)


def test_las_of_a_bare_cloud_is_as_fine_as_its_integers_allow(cloud, tmp_path):
    write(tmp_path / "cloud.laz", cloud)
    again = read(tmp_path / "cloud.laz").points
    assert np.abs(again - cloud.points).max() <= np.ptp(cloud.points, axis=0).max() * 10 / 2**31


@pytest.mark.parametrize(
    "suffix", [".ply", ".obj", ".off", ".xyz", ".txt", ".csv", ".npy", ".npz", ".pcd", ".laz"]
)
def test_kept_rows_equal_the_rows_of_the_file(suffix, cloud, tmp_path):
    source, target = tmp_path / f"cloud{suffix}", tmp_path / f"kept{suffix}"
    write(source, cloud)
    keep_rows(source, target, ROWS)
    before, after = read(source), read(target)
    assert np.array_equal(after.points, before.points[ROWS])
    for field in ("normals", "colors"):
        whole = getattr(before, field)
        assert whole is None or np.array_equal(getattr(after, field), whole[ROWS]), field
    assert before.attributes.keys() == after.attributes.keys()
    for name, values in before.attributes.items():
        assert np.array_equal(after.attributes[name], values[ROWS])
        assert after.attributes[name].dtype == values.dtype
    assert after.faces is None


@pytest.mark.filterwarnings("ignore:loadtxt")  # plyfile reads an empty list of an ascii file with it
@pytest.mark.parametrize(("text", "order"), [(True, "="), (False, "<"), (False, ">")])
def test_ply_keeps_types_lists_comments_and_further_elements(text, order, rng, tmp_path):
    vertex = np.zeros(N, dtype=[(a, "f4") for a in "xyz"] + [("label", "i2"), ("t", "f8"), ("near", "O")])
    for axis in "xyz":
        vertex[axis] = rng.normal(size=N)
    vertex["label"], vertex["t"] = rng.integers(-300, 300, N), rng.normal(size=N)
    vertex["near"] = [np.arange(i % 4, dtype="i4") for i in range(N)]
    camera = np.array([(1.5, 2.5)], dtype=[("fx", "f4"), ("fy", "f4")])
    face = np.array([([0, 1, 2],)], dtype=[("vertex_indices", "i4", (3,))])
    elements = [
        PlyElement.describe(vertex, "vertex", comments=["of the vertices"], val_types={"near": "i4"}),
        PlyElement.describe(camera, "camera"),
        PlyElement.describe(face, "face"),
    ]
    PlyData(elements, text, order, ["made by a test"], ["scanner 7"]).write(str(tmp_path / "a.ply"))
    keep_rows(tmp_path / "a.ply", tmp_path / "b.ply", ROWS)
    kept = PlyData.read(str(tmp_path / "b.ply"))
    assert (kept.text, kept.comments, kept.obj_info) == (text, ["made by a test"], ["scanner 7"])
    assert text or kept.byte_order == order
    assert [e.name for e in kept.elements] == ["vertex", "camera"]
    assert kept["vertex"].comments == ["of the vertices"]
    vertex = PlyData.read(str(tmp_path / "a.ply"))["vertex"]  # plyfile does not swap scalars beside a list
    for name in ("x", "y", "z", "label", "t"):
        assert np.array_equal(kept["vertex"][name], vertex[name][ROWS])
        assert kept["vertex"][name].dtype == vertex[name].dtype
    assert all(
        np.array_equal(a, b) for a, b in zip(kept["vertex"]["near"], vertex["near"][ROWS], strict=True)
    )
    assert np.array_equal(kept["camera"].data["fx"], camera["fx"])


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_las_keeps_dimensions_scale_offset_and_reference_system(suffix, rng, tmp_path):
    header = laspy.LasHeader(version="1.4", point_format=7)
    header.scales, header.offsets = [0.001, 0.001, 0.01], [500000, 4000000, 0]
    header.add_extra_dim(laspy.ExtraBytesParams(name="reflectance", type="f4"))
    wkt = b'PROJCS["WGS 84 / UTM zone 32N",AUTHORITY["EPSG","32632"]]\0'
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "OGC WKT", wkt))
    header.global_encoding.wkt = True
    las = laspy.LasData(header)
    las.x, las.y, las.z = (UTM + rng.normal(size=(N, 3))).T
    las.intensity = rng.integers(0, 65536, N)
    las.classification = rng.integers(0, 32, N)
    las.return_number = rng.integers(1, 4, N)
    las.gps_time = rng.uniform(1e8, 2e8, N)
    las.red = rng.integers(0, 65536, N)
    las.reflectance = rng.normal(size=N)
    las.write(str(tmp_path / f"a{suffix}"))
    keep_rows(tmp_path / f"a{suffix}", tmp_path / f"b{suffix}", ROWS)
    before, after = laspy.read(tmp_path / f"a{suffix}"), laspy.read(tmp_path / f"b{suffix}")
    assert after.header.point_count == len(ROWS)
    assert np.array_equal(after.header.scales, before.header.scales)
    assert np.array_equal(after.header.offsets, before.header.offsets)
    assert [v.record_data_bytes() for v in after.vlrs.get("WktCoordinateSystemVlr")] == [
        v.record_data_bytes() for v in before.vlrs.get("WktCoordinateSystemVlr")
    ]
    assert after.vlrs.get("WktCoordinateSystemVlr")
    for name in before.point_format.dimension_names:
        assert np.array_equal(np.array(after[name]), np.array(before[name])[ROWS]), name
    assert np.allclose(after.header.mins, after.xyz.min(axis=0))


@pytest.mark.parametrize("kind", [9, 10])
def test_wave_packets_of_several_channels_are_not_compressed(kind, rng, tmp_path):
    """lazrs would write other values: docs/upstream.md."""
    las = laspy.LasData(laspy.LasHeader(version="1.4", point_format=kind))
    las.x, las.y, las.z = rng.normal(size=(3, N))
    las.wavepacket_size = rng.integers(0, 999, N)
    las.scanner_channel = np.arange(N) % 2
    las.write(str(tmp_path / "a.las"))
    with pytest.raises(InputError, match=r"name a file that ends in \.las"):
        keep_rows(tmp_path / "a.las", tmp_path / "b.laz", ROWS)
    assert not (tmp_path / "b.laz").exists()
    for suffix, rows in ((".las", ROWS), (".laz", np.arange(0, N, 2))):
        keep_rows(tmp_path / "a.las", tmp_path / f"c{suffix}", rows)
        assert np.array_equal(laspy.read(tmp_path / f"c{suffix}").wavepacket_size, las.wavepacket_size[rows])


def test_a_dimension_of_a_las_called_as_a_coordinate_is_refused(tmp_path):
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.add_extra_dim(laspy.ExtraBytesParams(name="qqqq", type="f4"))
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.eye(3)
    las.write(str(tmp_path / "a.las"))
    content = (tmp_path / "a.las").read_bytes()
    (tmp_path / "a.las").write_bytes(content.replace(b"qqqq", b"x\0\0\0"))
    with pytest.raises(InputError, match="more than one column 'x'"):
        read(tmp_path / "a.las")


PCD_HEAD = b"""# .PCD v0.7
# scanner 7
VERSION 0.7
FIELDS x y z rgb ring _
SIZE 8 8 8 4 1 1
TYPE F F F F U U
COUNT 1 1 1 1 1 3
WIDTH %d
HEIGHT %d
VIEWPOINT 1 2 3 1 0 0 0
POINTS 200
"""


@pytest.mark.parametrize("encoding", list(pypcd4.Encoding)[:3])
def test_pcd_keeps_values_comments_packed_colour_encoding_and_viewpoint(encoding, rng, tmp_path):
    table = np.zeros(N, dtype="f8, f8, f8, f4, u1, u1, u1, u1")
    for i, axis in enumerate((UTM + rng.normal(size=(N, 3))).T):
        table[f"f{i}"] = axis
    table["f3"] = rng.choice([255, 65280, 16711680], N).astype(np.uint32).view(np.float32)
    table["f4"] = rng.integers(0, 9, N)
    (tmp_path / "a.pcd").write_bytes(PCD_HEAD % (N // 2, 2) + pcd_body(encoding, table))
    keep_rows(tmp_path / "a.pcd", tmp_path / "b.pcd", ROWS)
    kept = (tmp_path / "b.pcd").read_bytes()
    head = (PCD_HEAD % (len(ROWS), 1)).replace(b"POINTS 200", b"POINTS %d" % len(ROWS))
    assert kept.startswith(head + f"DATA {encoding.value}\n".encode())
    if encoding != pypcd4.Encoding.BINARY_COMPRESSED:
        assert kept[len(head) :] == pcd_body(encoding, table[ROWS])
    before, after = read(tmp_path / "a.pcd"), read(tmp_path / "b.pcd")
    assert np.array_equal(before.points, np.column_stack([table[f"f{i}"] for i in range(3)]))
    assert np.array_equal(before.colors[:, 2], (table["f3"].view(np.uint32) & 255) / 255)
    assert np.array_equal(after.points, before.points[ROWS])
    assert np.array_equal(after.colors, before.colors[ROWS])
    assert np.array_equal(after.attributes["ring"], table["f4"][ROWS])


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("VIEWPOINT 1 2 3 1 0 0 0\n", True),
        ("VIEWPOINT 0 0 0 1 0 0 0\n", False),
        ("", False),
        ("VIEWPOINT a\n", False),
    ],
)
def test_a_viewpoint_of_pcd_that_does_not_travel_is_said(line, said, tmp_path):
    head = (
        f"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n{line}POINTS 2\nDATA ascii\n"
    )
    (tmp_path / "a.pcd").write_text(f"{head}1 2 3\n4 5 6\n")
    notes = write(tmp_path / "a.ply", read(tmp_path / "a.pcd"))
    assert notes == ("its viewpoint, the pose of the sensor left out",) * said


def pcd_body(encoding, table):
    """The line DATA and what follows it."""
    begin = f"DATA {encoding.value}\n".encode()
    if encoding == pypcd4.Encoding.ASCII:
        return begin + "".join(" ".join(map(repr, row)) + "\n" for row in table.tolist()).encode()
    if encoding == pypcd4.Encoding.BINARY:
        return begin + table.tobytes()
    whole = b"".join(np.ascontiguousarray(table[name]).tobytes() for name in table.dtype.names)
    packed = lzf.compress(whole)
    return begin + struct.pack("<II", len(packed), len(whole)) + packed


def test_text_keeps_its_lines_byte_for_byte(tmp_path):
    rows = [b"%d.10\t2.0e0   -3 %d word\r\n" % (i, i) for i in range(9)]
    rows = [r.replace(b" word", b"") for r in rows]
    (tmp_path / "a.pts").write_bytes(b"# scan\n9\n" + b"".join(rows))
    keep_rows(tmp_path / "a.pts", tmp_path / "b.pts", np.array([1, 4]))
    assert (tmp_path / "b.pts").read_bytes() == b"# scan\n2\n" + rows[1] + rows[4]


def test_csv_finds_its_axes_by_name(tmp_path):
    (tmp_path / "a.csv").write_text("id,Y,X,Z\n7,2,1,3\n8,5,4,6\n")
    cloud = read(tmp_path / "a.csv")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.attributes["id"].tolist() == [7, 8]


def test_obj_keeps_lines_with_colours_and_normals(tmp_path):
    vertices = "vn 0 0 1\nv 0 0 0 0.1234567 0 1\nvn 0 1 0\nv 1 0 0 1 1 0\n"
    (tmp_path / "a.obj").write_text(f"# made by hand\nmtllib a.mtl\n{vertices}f 1//1 2//2 1//1\n")
    keep_rows(tmp_path / "a.obj", tmp_path / "b.obj", np.array([0]))
    assert (tmp_path / "b.obj").read_text() == "# made by hand\nvn 0 0 1\nv 0 0 0 0.1234567 0 1\n"
    assert read(tmp_path / "b.obj").colors.tolist() == [[0.1234567, 0, 1, 1]]


def test_obj_corners_may_count_backwards_and_have_many_sides(tmp_path):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\nv 9 9 9\nf 1/2/3 2 3\n"
    )
    assert read(tmp_path / "a.obj").faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]


def test_a_file_in_place_of_itself(cloud, tmp_path):
    write(tmp_path / "a.ply", cloud)
    keep_rows(tmp_path / "a.ply", tmp_path / "a.ply", ROWS)
    assert np.array_equal(read(tmp_path / "a.ply").points, cloud.points[ROWS])
    assert [p.name for p in tmp_path.iterdir()] == ["a.ply"]


def test_rows_of_one_format_do_not_become_another(cloud, tmp_path):
    write(tmp_path / "a.ply", cloud)
    with pytest.raises(InputError, match="not of one format"):
        keep_rows(tmp_path / "a.ply", tmp_path / "a.npz", ROWS)


def test_formats_of_meshlab_are_read_through_it(cloud, tmp_path):
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(cloud.points - UTM, cloud.faces))
    for suffix in (".stl", ".x3d", ".dae", ".3ds"):
        layers.save_current_mesh(str(tmp_path / f"a{suffix}"))
        again = read(tmp_path / f"a{suffix}")
        assert again.faces.shape == (50, 3)
        corners = (cloud.points - UTM)[cloud.faces]
        assert np.allclose(again.points[again.faces], corners, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("//X Y Z R G B\n1 2 3 4 5 6\n", set()),
        ("\ufeffx;y;z\n1;2;3\n", set()),
        ("# a scan\n# of a room\n1, 2, 3, 4\n", {"column_4"}),
        ("1\n1 2 3\n", set()),
    ],
)
def test_text_headers_of_other_programs(text, names, tmp_path):
    (tmp_path / "a.txt").write_text(text, encoding="utf-8")
    cloud = read(tmp_path / "a.txt")
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert set(cloud.attributes) == names


def test_a_copc_becomes_a_plain_laz(rng, tmp_path):
    header = laspy.LasHeader(version="1.4", point_format=7)
    header.vlrs.append(laspy.VLR("copc", 1, "", bytes(160)))
    las = laspy.LasData(header)
    las.x, las.y, las.z = rng.normal(size=(3, N))
    las.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("copc", 1000, "", bytes(32))])
    las.write(str(tmp_path / "a.copc.laz"))
    keep_rows(tmp_path / "a.copc.laz", tmp_path / "b.laz", ROWS)
    kept = laspy.read(tmp_path / "b.laz")
    assert kept.header.point_count == len(ROWS)
    assert "copc" not in {record.user_id for record in [*kept.vlrs, *(kept.evlrs or [])]}
    assert np.array_equal(kept.X, las.X[ROWS])
    with pytest.raises(InputError, match="COPC cannot be written"):
        keep_rows(tmp_path / "a.copc.laz", tmp_path / "c.copc.laz", ROWS)


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_las_keeps_attributes_of_several_columns_one_by_one(suffix, rng, tmp_path):
    flow = rng.normal(size=(50, 3))
    cloud = PointCloud(rng.normal(size=(50, 3)), attributes={"flow": flow, "a" * 40: flow[:, :2]})
    write(tmp_path / f"scan{suffix}", cloud)
    back = read(tmp_path / f"scan{suffix}").attributes
    assert np.array_equal(np.column_stack([back[f"flow_{i}"] for i in range(3)]), flow)
    assert np.array_equal(back["a" * 30 + "_2"], flow[:, 1])
