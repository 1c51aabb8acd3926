"""Files in parts: what is read is what the reader of whole files reads, what is written is what it writes."""

import laspy
import numpy as np
import pytest

from lpcompare.errors import InputError
from lpcompare.io import keep_rows, read, write
from lpcompare.io.rows import Damaged
from lpcompare.tiles.streams import STREAMS, count_points, note_on, read_rows, writer
from lpcompare.types import PointCloud

ROWS = np.arange(0, 6000, 7)


@pytest.mark.parametrize("suffix", STREAMS)
def test_parts_are_the_whole(files, sheet, suffix):
    path = files[suffix]
    assert count_points(path) == len(sheet)
    parts = [read_rows(path, start, min(start + 1700, 6000))[0] for start in range(0, 6000, 1700)]
    np.testing.assert_array_equal(np.concatenate(parts), read(path).points)


def written_in_parts(path, target, rows, step):
    with writer(target, path, len(rows)) as append:
        for start in range(0, count_points(path), step):
            stop = min(start + step, count_points(path))
            some = rows[(rows >= start) & (rows < stop)] - start
            append(path, read_rows(path, start, stop)[1][some])


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".npy"])
def test_a_copy_in_parts_has_the_bytes_of_a_copy_at_once(files, tmp_path, suffix):
    path = files[suffix]
    written_in_parts(path, tmp_path / f"parts{suffix}", ROWS, 1100)
    keep_rows(path, tmp_path / f"whole{suffix}", ROWS)
    assert (tmp_path / f"parts{suffix}").read_bytes() == (tmp_path / f"whole{suffix}").read_bytes()


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_a_copy_of_las_keeps_every_dimension_and_record(files, tmp_path, suffix):
    path, target = files[suffix], tmp_path / f"parts{suffix}"
    written_in_parts(path, target, ROWS, 1100)
    old, new = laspy.read(path), laspy.read(target)
    assert new.header.point_count == len(ROWS)
    assert (new.points.array == old.points.array[ROWS]).all()
    assert [v.record_data for v in new.vlrs if v.user_id == "someone"] == [b"kept as it is"]
    np.testing.assert_allclose(new.header.maxs, new.xyz.max(axis=0))


def test_a_file_of_other_steps_is_put_on_the_steps_of_the_first(files, tmp_path):
    other = laspy.read(files[".laz"])
    other.change_scaling([0.01] * 3, [400000, 4000000, 0])
    other.write(str(tmp_path / "other.laz"))
    with writer(tmp_path / "both.laz", files[".laz"], 20) as append:
        for path in (files[".laz"], tmp_path / "other.laz"):
            append(path, read_rows(path, 0, 10)[1])
    both = laspy.read(tmp_path / "both.laz")
    np.testing.assert_allclose(both.xyz[:10], both.xyz[10:], atol=0.006)


def test_a_file_of_other_properties_is_refused(files, tmp_path):
    np.save(tmp_path / "other.npy", np.eye(3))
    with (
        pytest.raises(InputError, match="other properties"),
        writer(tmp_path / "both.npy", files[".npy"], 20) as append,
    ):
        append(tmp_path / "other.npy", read_rows(tmp_path / "other.npy", 0, 3)[1])
    assert not (tmp_path / "both.npy").exists()


@pytest.mark.parametrize("suffix", STREAMS)
def test_a_file_that_is_cut_off_is_refused(files, tmp_path, suffix):
    cut = tmp_path / f"cut{suffix}"
    cut.write_bytes(files[suffix].read_bytes()[:-3000])
    with pytest.raises(InputError, match="cut"):
        count_points(cut)


def test_text_and_unknown_endings_are_refused_with_what_to_do(tmp_path):
    (tmp_path / "text.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n")
    with pytest.raises(InputError, match="convert it to binary"):
        count_points(tmp_path / "text.ply")
    with pytest.raises(InputError, match="convert it to one of"):
        count_points(tmp_path / "cloud.xyz")


def test_faces_are_left_out_and_said(tmp_path):
    cloud = PointCloud(np.eye(4)[:, :3], faces=np.array([[0, 1, 2], [1, 2, 3]]))
    write(tmp_path / "mesh.ply", cloud)
    assert note_on(tmp_path / "mesh.ply") == "face left out"
    written_in_parts(tmp_path / "mesh.ply", tmp_path / "some.ply", np.array([1, 3]), 2)
    assert read(tmp_path / "some.ply").faces is None
    np.testing.assert_array_equal(read(tmp_path / "some.ply").points, cloud.points[[1, 3]])


def test_the_tree_of_a_copc_is_left_out_and_said(files, tmp_path):
    las = laspy.read(files[".laz"])
    las.vlrs.append(laspy.VLR("copc", 1, "", bytes(160)))
    las.write(str(tmp_path / "tree.copc.laz"))
    assert note_on(tmp_path / "tree.copc.laz") == "a COPC becomes a plain LAZ"
    written_in_parts(tmp_path / "tree.copc.laz", tmp_path / "some.laz", ROWS, 1100)
    copied = laspy.read(tmp_path / "some.laz")
    assert (copied.points.array == las.points.array[ROWS]).all()
    assert "copc" not in {record.user_id for record in copied.vlrs}


@pytest.mark.parametrize("kind", [9, 10])
def test_wave_packets_of_several_channels_are_not_compressed_in_parts(kind, tmp_path):
    las = laspy.LasData(laspy.LasHeader(version="1.4", point_format=kind))
    las.x, las.y, las.z = np.random.default_rng(0).normal(size=(3, 40))
    las.scanner_channel = np.arange(40) // 20  # each part has one channel
    las.write(str(tmp_path / "a.las"))
    with pytest.raises(InputError, match=r"name a file that ends in \.las"):
        written_in_parts(tmp_path / "a.las", tmp_path / "b.laz", np.arange(40), 20)
    assert not (tmp_path / "b.laz").exists()
    written_in_parts(tmp_path / "a.las", tmp_path / "b.las", np.arange(40), 20)
    written_in_parts(tmp_path / "a.las", tmp_path / "c.laz", np.arange(20), 20)
    assert laspy.read(tmp_path / "c.laz").header.point_count == 20


def of_system(path, epsg):
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "", b"EPSG %d\0" % epsg))
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.eye(3)
    las.write(str(path))
    return path


def test_files_of_other_coordinate_systems_are_not_mixed(tmp_path):
    first, same, other = (
        of_system(tmp_path / f"{name}.las", epsg) for name, epsg in (("a", 25832), ("b", 25832), ("c", 25833))
    )
    for path in (same, other):
        with writer(tmp_path / f"both-{path.stem}.las", first, 6) as append:
            append(first, read_rows(first, 0, 3)[1])
            if path is other:
                with pytest.raises(Damaged, match="another coordinate reference system"):
                    append(path, read_rows(path, 0, 3)[1])
            else:
                append(path, read_rows(path, 0, 3)[1])


def test_waveforms_are_said_and_not_mixed(tmp_path):
    for name in "ab":
        las = laspy.LasData(laspy.LasHeader(version="1.4", point_format=9))
        las.x, las.y, las.z = np.eye(3)
        las.write(str(tmp_path / f"{name}.las"))
        content = bytearray((tmp_path / f"{name}.las").read_bytes())
        content[227:235] = (123).to_bytes(8, "little")  # a record of waveforms that is not there
        (tmp_path / f"{name}.las").write_bytes(content)
    assert "its waveforms are left out" in note_on(tmp_path / "a.las")
    with writer(tmp_path / "both.las", tmp_path / "a.las", 6) as append:
        append(tmp_path / "a.las", read_rows(tmp_path / "a.las", 0, 3)[1])
        with pytest.raises(Damaged, match="waveforms of their own"):
            append(tmp_path / "b.las", read_rows(tmp_path / "b.las", 0, 3)[1])


def test_scans_of_other_viewpoints_are_not_mixed(tmp_path):
    for name in "ab":
        write(tmp_path / f"{name}.pcd", PointCloud(np.eye(3)))
    content = (tmp_path / "b.pcd").read_bytes()
    (tmp_path / "b.pcd").write_bytes(content.replace(b"VIEWPOINT 0.0", b"VIEWPOINT 7.0"))
    with writer(tmp_path / "both.pcd", tmp_path / "a.pcd", 6) as append:
        append(tmp_path / "a.pcd", read_rows(tmp_path / "a.pcd", 0, 3)[1])
        with pytest.raises(Damaged, match="another viewpoint than"):
            append(tmp_path / "b.pcd", read_rows(tmp_path / "b.pcd", 0, 3)[1])
