"""The round trip through the files that MeshLab writes."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from lpcompare.io import keep_rows, read


@pytest.fixture
def scan():
    return str(
        Path(find_spec("pymeshlab").submodule_search_locations[0])
        / "tests/sample_meshes/colored_airplane.ply"
    )


@pytest.mark.parametrize(("suffix", "digits"), [(".ply", 0), (".obj", 0), (".off", 0), (".xyz", 5e-7)])
def test_meshlab_to_lpcompare_and_back(suffix, digits, scan, tmp_path):
    """MeshLab writes the file, we keep some rows, MeshLab reads them: positions and colours are the same."""
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    layers.load_new_mesh(scan)
    layers.compute_normal_for_point_clouds()
    given = layers.current_mesh()
    # an OFF with colours and normals is one that MeshLab itself misreads
    options = {"save_vertex_normal": False} if suffix == ".off" else {}
    layers.save_current_mesh(str(tmp_path / f"scan{suffix}"), **options)
    rows = np.arange(3, given.vertex_number(), 10)
    keep_rows(tmp_path / f"scan{suffix}", tmp_path / f"thin{suffix}", rows)
    layers.load_new_mesh(str(tmp_path / f"thin{suffix}"))
    back, given = layers.current_mesh(), layers.mesh(0)
    assert np.allclose(back.vertex_matrix(), given.vertex_matrix()[rows], rtol=0, atol=digits)
    if suffix != ".xyz":
        # MeshLab rounds the colours of an OBJ when it writes and when it reads
        off = 2 / 255 if suffix == ".obj" else 0
        assert np.abs(back.vertex_color_matrix() - given.vertex_color_matrix()[rows]).max() <= off
    if suffix == ".ply":
        assert np.array_equal(back.vertex_scalar_array(), given.vertex_scalar_array()[rows])


def test_binary_and_ascii_ply_of_meshlab_hold_the_same(scan, tmp_path):
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    layers.load_new_mesh(scan)
    for name, binary in (("a", False), ("b", True)):
        path = str(tmp_path / f"{name}.ply")
        layers.save_current_mesh(path, binary=binary, save_vertex_normal=True)
    one, other = (read(tmp_path / f"{name}.ply") for name in "ab")
    assert np.abs(one.points - other.points).max() < 1e-12
    assert np.array_equal(one.colors, other.colors)
    assert np.array_equal(one.faces, other.faces)
    assert one.normals is not None
