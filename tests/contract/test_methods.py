"""What every method found must keep: counts, subsets, repeatability, clean inputs."""

import inspect
import subprocess
import sys

import numpy as np
import pytest

from lpcompare.errors import NotApplicable
from lpcompare.registry import METHODS, call
from lpcompare.types import PointCloud, Simplification

N_POINTS, TARGET = 600, 150


def usable():
    for name in METHODS:
        missing = METHODS.missing(name)
        yield pytest.param(name, marks=pytest.mark.skipif(bool(missing), reason=missing))


@pytest.fixture(scope="module")
def cloud():
    """A closed triangulated sphere: points, normals and faces."""
    from scipy.spatial import ConvexHull

    rng = np.random.default_rng(7)
    points = rng.normal(size=(N_POINTS, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return PointCloud(
        points, normals=points.copy(), faces=outward(points, ConvexHull(points).simplices), name="sphere"
    )


def outward(points, faces):
    a, b, c = (points[faces[:, i]] for i in range(3))
    inward = np.einsum("fi,fi->f", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward][:, ::-1]
    return faces.astype(np.intp)


def run(name, cloud, target=TARGET, seed=0):
    return call(name, cloud, target, random_state=seed)


@pytest.mark.parametrize("name", list(usable()))
def test_result_keeps_the_promises_of_its_traits(name, cloud):
    traits, before = METHODS.traits(name), cloud.points.copy()
    result = run(name, cloud)
    assert isinstance(result, Simplification)
    assert result.points.shape == (len(result), 3)
    assert result.points.dtype == np.float64
    assert np.isfinite(result.points).all()
    assert np.array_equal(cloud.points, before), "the input was changed"
    assert all(isinstance(v, float) and v >= 0 for v in result.timings.values())
    if traits.exact_count:
        assert len(result) == TARGET
    else:
        assert 1 <= len(result) <= N_POINTS
    if traits.keeps_indices:
        assert result.indices is not None
        assert (np.diff(result.indices) > 0).all(), "indices ascend and are distinct"
        assert np.array_equal(result.points, cloud.points[result.indices])
    else:
        assert result.indices is None


@pytest.mark.parametrize("name", METHODS.names())
def test_source_says_what_it_is_and_where_it_comes_from(name):
    traits = METHODS.traits(name)
    assert METHODS.summary(name).endswith(".")
    assert traits.wraps
    assert traits.licence
    assert not traits.requires or traits.extra


@pytest.mark.parametrize("name", list(usable()))
def test_function_takes_points_count_rng_and_keyword_settings_with_defaults(name):
    parameters = list(inspect.signature(METHODS.get(name)).parameters.values())
    assert [p.name for p in parameters[:2]] == ["points", "target_count"]
    assert all(p.kind is p.KEYWORD_ONLY for p in parameters[2:])
    assert "rng" in {p.name for p in parameters}
    assert METHODS.get(name).__doc__


@pytest.mark.parametrize("name", list(usable()))
def test_a_method_that_needs_a_mesh_declines_a_cloud_without_faces(name, cloud):
    if METHODS.traits(name).needs_mesh:
        with pytest.raises(NotApplicable):
            run(name, PointCloud(cloud.points, name="bare"))


IN_PROCESS = ("lpcompare", "numpy", "scipy")
"""What does not keep a state of its own between two calls."""

DRAW = """
import hashlib, sys
import numpy as np
from lpcompare.registry import call
from lpcompare.types import PointCloud
name, path = sys.argv[1:]
with np.load(path) as file:
    cloud = PointCloud(file["points"], faces=file["faces"])
result = call(name, cloud, 150, random_state=3)
print(len(result), hashlib.sha256(result.points.tobytes()).hexdigest())
"""


def seeded(*, in_process):
    return [p for p in usable() if in_process == METHODS.traits(p.values[0]).wraps.startswith(IN_PROCESS)]


@pytest.mark.parametrize("name", seeded(in_process=True))
def test_same_seed_gives_the_same_points(name, cloud):
    assert np.array_equal(run(name, cloud, seed=3).points, run(name, cloud, seed=3).points)


@pytest.mark.parametrize("name", seeded(in_process=False))
def test_same_seed_gives_the_same_points_in_a_fresh_process(name, cloud, tmp_path):
    """A wrapped library may keep a generator of its own; the harness gives each case a process."""
    np.savez(tmp_path / "cloud.npz", points=cloud.points, faces=cloud.faces)
    command = [sys.executable, "-W", "error", "-c", DRAW, name, str(tmp_path / "cloud.npz")]
    draws = [
        subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
        for _ in range(2)
    ]
    assert draws[0] == draws[1]
    assert draws[0].split()[0].isdigit()
