"""What a file has beside its points is left out of other formats, and said so."""

import laspy
import numpy as np
import pytest

from lpcompare.io import keep_rows, read, write

AXES = "property float x\nproperty float y\nproperty float z\n"
TEXTS = {
    "a.ply": (
        f"ply\nformat ascii 1.0\nelement vertex 1\n{AXES}element camera 1\nproperty float f\nend_header\n1 2 3\n4\n",
        "its element 'camera' left out",
    ),
    "a.obj": ("v 1 2 3\nvt 0 0\n", "its texture coordinates left out"),
    "b.obj": ("v 1 2 3\nvn 0 0 1\nvn 0 1 0\n", "its normals, of which points have none or several, left out"),
    "c.obj": ("v 1 2 3 0.5\n", "further numbers of its points left out"),
    "a.csv": (f"x,y,z\n{2**53 + 1},2,3\n", "digits of its coordinates that a double does not hold left out"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text(name, tmp_path):
    text, note = TEXTS[name]
    (tmp_path / name).write_text(text)
    cloud = read(tmp_path / name)
    assert note in write(tmp_path / "b.npz", cloud.take(np.array([0])))
    assert keep_rows(tmp_path / name, tmp_path / f"kept{name}", np.array([0])) == ()
    assert write(tmp_path / "c.npz", read(tmp_path / "b.npz")) == (), "what is gone is said once"


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_records_of_a_las(suffix, tmp_path):
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.add_extra_dim(laspy.ExtraBytesParams(name="pulse", type="f4"))
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "OGC WKT", b'PROJCS["WGS 84"]\0'))
    header.vlrs.append(laspy.VLR("lab", 7, "a note", b"12345"))
    header.global_encoding.wkt = True
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.eye(3)
    las.write(str(tmp_path / f"a{suffix}"))
    said = ("its coordinate reference system left out", "1 further records of its header left out")
    assert write(tmp_path / "b.npz", read(tmp_path / f"a{suffix}")) == said
    assert keep_rows(tmp_path / f"a{suffix}", tmp_path / f"b{suffix}", np.array([0])) == ()


def test_arrays_of_another_length_and_wide_numbers(tmp_path):
    np.savez(tmp_path / "a.npz", points=np.array([[2**53 + 1, 2, 3]]), pose=np.eye(4))
    said = ("digits of its coordinates that a double does not hold left out", "its array 'pose' left out")
    assert write(tmp_path / "a.ply", read(tmp_path / "a.npz")) == said
    np.save(tmp_path / "a.npy", np.array([[2**53 + 1, 2, 3]]))
    assert write(tmp_path / "a.ply", read(tmp_path / "a.npy")) == said[:1]
    np.save(tmp_path / "a.npy", np.array([[2**53, 2, 3]]))
    assert write(tmp_path / "a.ply", read(tmp_path / "a.npy")) == ()
