"""Each rival on scans, duplicates, one point fewer than there are, and survey coordinates."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from lpcompare.errors import InputError, NotApplicable
from lpcompare.registry import METHODS, call
from lpcompare.types import PointCloud

RIVALS = [
    pytest.param(n, marks=pytest.mark.skipif(bool(METHODS.missing(n)), reason=METHODS.missing(n)))
    for n in METHODS
    if not n.startswith("lp_")
]

LIBRARIES = [p for p in RIVALS if not METHODS.traits(p.values[0]).programs]
"""Without programs, which start anew for each try of a calibration; the contract tries a line and a point on all."""

STEPPED = (
    "cgal_hierarchy",
    "open3d_uniform",
    "meshoptimizer_points",
    "cloudcompare_octree",
    "vtk_voxel_grid",
)
"""Optional rivals that can have certain counts only."""


def run(name, cloud, target):
    return call(name, cloud, target, random_state=0)


def sphere(n, scale=1.0, shift=0.0):
    points = np.random.default_rng(3).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return PointCloud(points * scale + shift, faces=ConvexHull(points).simplices.astype(np.intp))


def expect_good(name, cloud, target, within):
    try:
        result = run(name, cloud, target)
    except NotApplicable:
        return None
    assert np.isfinite(result.points).all()
    assert abs(len(result) - target) <= within or name in STEPPED
    if result.indices is not None:
        assert len(np.unique(result.indices)) == len(result)
        assert np.array_equal(result.points, cloud.points[result.indices])
    return result


@pytest.mark.parametrize("name", RIVALS)
def test_one_point_fewer_than_there_are(name):
    expect_good(name, sphere(100), 99, within=0 if METHODS.traits(name).exact_count else 2)


@pytest.mark.parametrize("name", RIVALS)
def test_duplicates(name):
    base = sphere(400)
    cloud = PointCloud(np.vstack([base.points, base.points[:200]]), faces=base.faces)
    expect_good(name, cloud, 60, within=3)
    expect_good(name, cloud, 550, within=0)


@pytest.mark.parametrize("name", RIVALS)
def test_survey_coordinates_give_points_on_the_same_surface(name):
    center = np.array([5e5, 4e6, 300.0])
    result = expect_good(name, sphere(800, scale=2000.0, shift=center), 160, within=4)
    radii = np.linalg.norm(result.points - center, axis=1)
    assert ((radii > 1500) & (radii < 2100)).all()


@pytest.mark.parametrize("name", LIBRARIES)
@pytest.mark.parametrize(
    "points", [np.ones((30, 3)), np.outer(np.arange(30.0), [1, 2, 3])], ids=["one", "line"]
)
def test_a_cloud_without_a_surface(name, points):
    expect_good(name, PointCloud(points), 10, within=1)


@pytest.mark.parametrize("name", LIBRARIES)
@pytest.mark.parametrize("target", [1, 3])
def test_few_points(name, target):
    expect_good(name, PointCloud(np.eye(3)), target, within=2)


@pytest.mark.parametrize(
    "name",
    [
        n
        for n in METHODS
        if not n.startswith("lp_") and not (METHODS.traits(n).extra or METHODS.traits(n).install)
    ],
)
@pytest.mark.parametrize("distance", ["1e4", "1e9"])
def test_an_outlier_far_away_neither_hangs_nor_shortens_the_result(name, distance, fresh):
    answer = fresh("far_outlier", name, distance).splitlines()[-1]
    if not answer.startswith("declined: "):
        assert abs(int(answer) - 200) <= 2
    else:
        assert distance == "1e9" or METHODS.traits(name).needs_mesh


@pytest.mark.parametrize("name", RIVALS)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_a_number_is_refused(name, value):
    cloud = sphere(50)
    cloud.points[7, 1] = value
    with pytest.raises(InputError):
        run(name, cloud, 20)


@pytest.mark.parametrize("name", RIVALS)
@pytest.mark.parametrize("target", [0, -3, 51])
def test_a_count_that_cannot_be_is_refused(name, target):
    with pytest.raises(InputError):
        run(name, sphere(50), target)


@pytest.fixture(scope="module")
def scan(shared_models, request):
    """A scanned room; every eighth point of it, or all with --long: the law is one for any count."""
    from lpcompare.io import read

    cloud = read(shared_models / "scans" / "lidar-room-56159.ply")
    return cloud if request.config.getoption("--long") else cloud.take(np.arange(0, len(cloud), 8))


@pytest.mark.shared
@pytest.mark.parametrize("name", RIVALS)
def test_a_scan_without_faces(name, scan):
    target = len(scan) // 10
    result = expect_good(name, scan, target, within=max(3, target // 90))
    assert (result is None) == METHODS.traits(name).needs_mesh
