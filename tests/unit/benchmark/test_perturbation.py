"""Damage to the input: how much, where, and the same every time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.benchmark.perturbation import LARGEST_LEVEL, Perturbation, mean_spacing, perturb
from lpcompare.errors import InputError, UnknownName
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.models.synthetic import torus
from lpcompare.registry import METHODS
from lpcompare.types import PointCloud

KINDS = [kind for kind in LARGEST_LEVEL if kind != "none"]


@pytest.fixture(scope="module")
def cloud():
    rng = np.random.default_rng(2)
    bare = torus(16, 16)
    return PointCloud(
        bare.points, bare.normals, rng.random((256, 4)), {"id": np.arange(256)}, bare.faces, name="torus"
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("level", [0.0, 0.05, 0.5])
def test_same_seed_same_damage_and_the_clean_cloud_is_left_alone(cloud, kind, level):
    before = cloud.points.copy()
    first, second = (perturb(cloud, Perturbation(kind, level), seed=4) for _ in range(2))
    assert np.array_equal(first.points, second.points)
    assert np.array_equal(cloud.points, before)
    assert (level == 0) == np.array_equal(first.points, before)
    other = perturb(cloud, Perturbation(kind, level), seed=5)
    assert level == 0 or not np.array_equal(first.points, other.points)


@given(kind=st.sampled_from(KINDS), level=st.floats(0, 0.9), seed=st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_everything_a_cloud_carries_stays_in_step_with_its_points(kind, level, seed):
    bare = torus(16, 16)
    cloud = PointCloud(bare.points, bare.normals, None, {"id": np.arange(256)}, bare.faces, name="torus")
    damaged = perturb(cloud, Perturbation(kind, level), seed)
    assert len(damaged.normals) == len(damaged.attributes["id"]) == len(damaged)
    assert np.isfinite(damaged.points).all()
    corners = damaged.points[damaged.faces]
    if kind in ("uneven", "missing"):
        rows = damaged.attributes["id"]
        assert np.array_equal(damaged.points, cloud.points[rows])
        assert np.array_equal(corners, cloud.points[rows[damaged.faces]])


def test_noise_has_the_stated_deviation(cloud):
    shift = perturb(cloud, Perturbation("noise", 0.5), 0).points - cloud.points
    assert shift.std() == pytest.approx(0.5 * mean_spacing(cloud.points), rel=0.1)


def test_outliers_and_missing_regions_have_the_stated_size(cloud):
    assert len(perturb(cloud, Perturbation("outliers", 0.25), 0)) == 256 + 64
    missing = perturb(cloud, Perturbation("missing", 0.25), 0)
    assert len(missing) == 256 - 64
    gone = np.setdiff1d(np.arange(256), missing.attributes["id"])
    assert np.ptp(cloud.points[gone], axis=0).max() < np.ptp(cloud.points, axis=0).max()


def test_uneven_keeps_one_end_and_thins_the_other(cloud):
    kept = perturb(cloud, Perturbation("uneven", 1.0), 0).points
    axis = int(np.ptp(cloud.points, axis=0).argmax())
    middle = np.median(cloud.points[:, axis])
    assert (kept[:, axis] < middle).sum() > 1.5 * (kept[:, axis] > middle).sum()


def test_impossible_damage_is_refused():
    with pytest.raises(UnknownName, match="rust"):
        Perturbation("rust", 0.1).check()
    with pytest.raises(InputError, match="from 0 to 1"):
        Perturbation("outliers", 1.5).check()
    with pytest.raises(InputError):
        Perturbation("noise", float("nan")).check()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("points", [np.zeros((1, 3)), np.zeros((5, 3)), np.arange(12.0).reshape(4, 3)])
def test_degenerate_clouds_can_be_damaged(kind, points):
    assert np.isfinite(perturb(PointCloud(points), Perturbation(kind, 0.5), 0).points).all()


@pytest.mark.parametrize("method", [name for name in METHODS if METHODS.traits(name).needs_mesh])
def test_methods_that_need_the_mesh_never_see_outliers(method):
    clean = torus(16, 16)
    damaged = perturb(clean, Perturbation("outliers", 1.0), 0)
    settings = METHODS.module(method).calibrate(
        damaged.points, 64, rng=np.random.default_rng(0), cloud=damaged
    )
    result = METHODS.get(method)(damaged.points, 64, rng=np.random.default_rng(0), cloud=damaged, **settings)
    distances, _ = Neighbors(damaged.points[len(clean) :]).query(result.points, 1)
    assert distances.min() > 1e-3
