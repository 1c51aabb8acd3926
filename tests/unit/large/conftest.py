"""Small clouds on disk, in every format that is read in parts."""

import laspy
import numpy as np
import pytest

from lpcompare.io import write
from lpcompare.types import PointCloud


def wavy(n, seed=0):
    """A curved sheet with a fold, in steps of a thousandth."""
    rng = np.random.default_rng(seed)
    x, y = rng.random((2, n)) * [[20], [10]]
    z = np.sin(x) + np.abs(y - 5)
    return np.round(np.column_stack([x + 500000, y + 4000000, z + 100]), 3)


@pytest.fixture(scope="session")
def sheet():
    return wavy(6000)


@pytest.fixture(scope="session")
def files(sheet, tmp_path_factory):
    """One file of each format, with more than coordinates in it."""
    folder = tmp_path_factory.mktemp("files")
    numbers = {"id": np.arange(len(sheet), dtype=np.int32), "weight": np.sqrt(np.arange(len(sheet)))}
    cloud = PointCloud(sheet, attributes=numbers)
    for suffix in (".ply", ".pcd"):
        write(folder / f"sheet{suffix}", cloud)
    np.save(folder / "sheet.npy", np.column_stack([sheet, numbers["weight"]]))
    for suffix in (".las", ".laz"):
        las = laspy.LasData(_header())
        las.xyz = sheet
        las.intensity = numbers["id"] % 65535
        las["score"] = numbers["weight"]
        las.write(str(folder / f"sheet{suffix}"))
    return {path.suffix: path for path in folder.iterdir()}


def _header():
    header = laspy.LasHeader(version="1.4", point_format=7)
    header.scales, header.offsets = [0.001] * 3, [500000, 4000000, 0]
    header.add_extra_dim(laspy.ExtraBytesParams("score", "f8"))
    header.vlrs.append(laspy.VLR("someone", 42, "a note", b"kept as it is"))
    return header
