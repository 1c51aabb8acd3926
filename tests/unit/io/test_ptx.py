"""PTX: every scan, every point, in its place."""

import numpy as np
import pytest

from lpcompare.errors import InputError
from lpcompare.io import read, write
from lpcompare.types import PointCloud

POSE = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
STRAIGHT = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
TURNED_AND_SHIFTED = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n"
POINTS = "1 2 3 0.5 255 0 51\n0 0 0 0.5 0 0 0\n4 5 6 0.25 0 0 0\n7 8 9.123456789012 1 0 0 0\n"


def test_every_scan_is_moved_to_its_place_and_a_ray_without_an_echo_is_nan(tmp_path):
    path = tmp_path / "a.ptx"
    path.write_text(f"2\n2\n{POSE}{STRAIGHT}{POINTS}2\n2\n{POSE}{TURNED_AND_SHIFTED}{POINTS}")
    cloud = read(path)
    assert np.isnan(cloud.points[[1, 5]]).all()
    cloud = read(path, drop_invalid=True)
    assert cloud.points[:3].tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9.123456789012]]
    assert np.allclose(cloud.points[3:], [[8, 21, 33], [5, 24, 36], [2, 27, 39.123456789012]], atol=1e-13)
    assert cloud.attributes["intensity"].tolist() == [0.5, 0.25, 1] * 2
    assert cloud.colors[0].tolist() == [1, 0, 0.2, 1]


def test_colours_that_a_scan_does_not_have_are_nan_and_said_when_written(tmp_path):
    path = tmp_path / "a.ptx"
    path.write_text(f"2\n2\n{POSE}{STRAIGHT}{POINTS}1\n1\n{POSE}{STRAIGHT}1 1 1 1\n")
    cloud = read(path)
    assert len(cloud) == 5
    assert np.isnan(cloud.colors[4, :3]).all()
    assert cloud.colors[0].tolist() == [1, 0, 0.2, 1]
    assert write(tmp_path / "a.ply", cloud) == ("colors of 1 point are not known and become 0",)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (f"2\n3\n{POSE}{STRAIGHT}{POINTS}", "promises 2 x 3 points and there are 4 lines"),
        (f"-2\n-2\n{POSE}{STRAIGHT}{POINTS}", "promises -2 x -2 points"),
        (f"2\n2\n{POSE}{STRAIGHT}{POINTS}2\n2\n", "a scan ends in its header, after 2 of 10 lines"),
        (f"2\n2\n{POSE}{STRAIGHT}" + "1 2\n" * 4, r"a matrix of shape \(4, 4\) and 2 columns"),
        (f"2\n2\n{POSE}" + "0 0 0 0\n" * 4 + POINTS, "less than space"),
        (f"2\n2\n{POSE}nan{STRAIGHT[1:]}{POINTS}", "less than space"),
        ("\n\n", "holds no points"),
    ],
)
def test_damaged_files(text, reason, tmp_path):
    path = tmp_path / "a.ptx"
    path.write_text(text)
    with pytest.raises(InputError, match=reason):
        read(path)


def test_it_cannot_be_written(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write(tmp_path / "a.ptx", PointCloud(np.eye(3)))
