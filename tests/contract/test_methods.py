"""What every method found must keep: counts, subsets, repeatability, clean inputs."""

import numpy as np
import pytest

from lpcompare.errors import InputError, MethodError, NotApplicable
from lpcompare.registry import METHODS, call
from lpcompare.simplify import simplify
from lpcompare.testing import check_method, sphere
from lpcompare.types import PointCloud


def usable():
    for name in METHODS:
        missing = METHODS.missing(name)
        yield pytest.param(name, marks=pytest.mark.skipif(bool(missing), reason=missing))


@pytest.fixture(scope="module")
def cloud():
    return sphere()


@pytest.mark.parametrize("name", list(usable()))
def test_a_method_keeps_its_promises(name):
    check_method(name)


@pytest.mark.parametrize("name", METHODS.names())
def test_source_says_what_it_is_and_where_it_comes_from(name):
    traits = METHODS.traits(name)
    assert METHODS.summary(name).endswith(".")
    assert traits.wraps
    assert traits.licence
    assert traits.family
    assert not traits.requires or traits.extra


@pytest.mark.parametrize("name", list(usable()))
def test_a_method_that_needs_a_mesh_declines_a_cloud_without_faces(name, cloud):
    if METHODS.traits(name).needs_mesh:
        with pytest.raises(NotApplicable):
            call(name, PointCloud(cloud.points, name="bare"), 150)


IN_PROCESS = ("lpcompare", "numpy", "scipy")
"""What does not keep a state of its own between two calls."""


def outside():
    """Methods that call a library; a program starts anew for each call, which the promises try."""
    for method in usable():
        traits = METHODS.traits(method.values[0])
        if traits.repeatable and not traits.programs and not traits.wraps.startswith(IN_PROCESS):
            yield method


@pytest.mark.parametrize("name", list(outside()))
def test_same_seed_gives_the_same_points_in_a_fresh_process(name, cloud, tmp_path, fresh):
    """A wrapped library may keep a generator of its own; the harness gives each case a process."""
    np.savez(tmp_path / "cloud.npz", points=cloud.points, faces=cloud.faces)
    draws = [fresh("draw", name, str(tmp_path / "cloud.npz")) for _ in range(2)]
    assert draws[0] == draws[1]
    assert draws[0].split()[0].isdigit()


@pytest.mark.parametrize("name", [n for n in METHODS if METHODS.traits(n).own_process])
def test_the_public_function_repeats_what_only_a_fresh_process_repeats(name):
    points = np.random.default_rng(7).normal(size=(25_000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    first, again = (simplify(points, target_count=2500, method=name, random_state=3) for _ in range(2))
    assert np.array_equal(first.points, again.points)


def test_an_order_is_for_progressive_methods_only(cloud):
    with pytest.raises(InputError, match="choose a progressive method"):
        simplify(cloud, target_count=10, method="random_sample", order=True)


def test_a_method_that_breaks_a_promise_is_named(cloud, monkeypatch):
    import lpcompare_baselines.random_sample as file

    def cheat(points, target_count, *, rng):
        """Return one point too few."""
        return file.Simplification(points[: target_count // 2], np.arange(target_count // 2))

    monkeypatch.setattr(file, "random_sample", cheat)
    with pytest.raises(MethodError, match="random_sample: The method returned 75 points and promises"):
        call("random_sample", cloud, 150)
