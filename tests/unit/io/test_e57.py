"""E57: scans stand in their poses, and what MeshLab leaves out or makes up is said or left out.

``two_scans.e57`` was written by pye57 0.4.19. Each scan has the points (i, i % 2, (i % 3) / 2), i < 8. The first has
colors and is turned by 90 degrees about z and moved by (100, 200, 300). The second has an intensity, rows and columns,
an invalid point, is turned by 90 degrees about x and moved by (-100, 0, 0).
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from lpcompare.errors import InputError
from lpcompare.io import read, write

pytest.importorskip("pymeshlab")
SCANS = Path(__file__).with_name("two_scans.e57")


@pytest.fixture(scope="module")
def cloud():
    return read(SCANS)


def test_scans_stand_in_their_poses(cloud):
    x, y, z = (i := np.arange(8.0)), i % 2, (i % 3) / 2
    first, second = np.c_[-y, x, z] + [100, 200, 300], np.c_[x, -z, y] - [100, 0, 0]
    np.testing.assert_allclose(cloud.points, np.vstack([first, np.delete(second, 3, axis=0)]), atol=1e-6)


def test_no_color_is_made_up(cloud):
    assert np.isfinite(cloud.colors[:8]).all()
    assert np.isnan(cloud.colors[8:]).all()
    assert np.array_equal(cloud.attributes["quality"][8:], np.delete(np.arange(8.0), 3) * 100)


def test_what_is_left_out_is_said(cloud, tmp_path):
    notes = write(tmp_path / "a.ply", cloud)
    assert "1 of 16 points (marked as invalid) left out" in notes
    assert {"its field 'rowIndex' left out", "its field 'columnIndex' left out"} <= set(notes)


@pytest.mark.parametrize("at", [24, 32, 40])
def test_a_damaged_header_is_refused(at, tmp_path):
    shutil.copy(SCANS, tmp_path / "a.e57")
    content = bytearray(SCANS.read_bytes())
    content[at : at + 8] = b"\xff" * 8
    (tmp_path / "a.e57").write_bytes(content)
    with pytest.raises(InputError, match="cannot be read as E57"):
        read(tmp_path / "a.e57")
