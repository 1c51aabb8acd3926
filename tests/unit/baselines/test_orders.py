"""Progressive methods: their prefixes, their spacing, and other implementations of the same."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from lpcompare.registry import METHODS
from lpcompare_baselines._buckets import farthest_points
from lpcompare_baselines.farthest_point import farthest_point
from lpcompare_baselines.iterative_sampling import iterative_sampling, removal_order
from lpcompare_baselines.yuksel_elimination import eliminate, surface_area, yuksel_elimination


def rng(seed=0):
    return np.random.default_rng(seed)


def single(n, seed=0):
    return rng(seed).normal(size=(n, 3)).astype(np.float32).astype(float)


def first(result, n):
    return np.sort(result.indices[result.info["order"] < n])


def needs(name):
    return pytest.mark.skipif(bool(METHODS.missing(name)), reason=METHODS.missing(name))


@pytest.mark.parametrize("method", [farthest_point, iterative_sampling])
def test_the_first_points_are_the_result_for_fewer(method):
    points = np.vstack([single(800), single(800)[:100]])
    long = method(points, 850, rng=rng())
    for n in (1, 60, 400, 800):
        assert np.array_equal(first(long, n), method(points, n, rng=rng()).indices)


def plain_removal(points):
    """Every score anew before each removal; of equal ones the later row."""
    left, charged, gone = list(range(len(points))), np.zeros(len(points)), []
    while len(left) > 1:
        squared = np.square(points[left][:, None] - points[left]).sum(axis=2)
        np.fill_diagonal(squared, np.inf)
        nearest = squared.argmin(axis=1)
        score = squared.min(axis=1) + charged[left]
        place = np.flatnonzero(score == score.min())[-1]
        charged[left[nearest[place]]] += score[place]
        gone.append(left.pop(place))
    return [*left, *gone[::-1]]


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 120))
def test_iterative_sampling_is_the_plain_loop(seed, n):
    points = rng(seed).normal(size=(n, 3))
    assert removal_order(points).tolist() == plain_removal(points)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(0.05, 0.9))
def test_elimination_takes_the_heaviest_point_each_time(seed, share):
    """Weights anew before each removal; mutual neighbors may tie, so weights are compared and not rows."""
    points = rng(seed).random((150, 3)) * [1, 1, 0]
    n_left, area = max(1, int(share * 150)), surface_area(points)
    reach = 2 * np.sqrt(area / (2 * np.sqrt(3) * n_left))
    least = reach * 0.65 * (1 - (n_left / 150) ** 1.5)
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    terms = np.where(distances < reach, (1 - np.maximum(distances, least) / reach) ** 8, 0.0)
    np.fill_diagonal(terms, 0.0)
    left = np.ones(150, bool)
    for row in eliminate(points, n_left, area):
        weights = terms[:, left].sum(axis=1)
        assert left[row]
        assert weights[row] == pytest.approx(weights[left].max(), abs=1e-9)
        left[row] = False
    assert left.sum() == n_left


def test_elimination_spreads_its_points_and_every_prefix():
    points = rng().random((6000, 3)) * [1, 1, 0]
    result = yuksel_elimination(points, 600, rng=rng())
    for n, least in ((600, 0.6), (300, 0.5), (100, 0.5)):
        kept = points[first(result, n)]
        radius = np.sqrt(1 / (2 * np.sqrt(3) * n))
        assert cKDTree(kept).query(kept, 2)[0][:, 1].min() > least * 2 * radius


def test_the_area_of_a_square_is_found():
    assert surface_area(rng().random((20000, 3)) * [1, 1, 0]) == pytest.approx(1.0, rel=0.1)


@needs("fpsample_farthest_point")
def test_fpsample_takes_the_same_points_from_the_same_first_one():
    points = single(3000)
    theirs = METHODS.get("fpsample_farthest_point")(points, 400, rng=rng())
    order = theirs.indices[np.argsort(theirs.info["order"])]
    assert np.array_equal(order, farthest_points(points, 400, int(order[0])))


@needs("meshlib_iterative")
def test_meshlib_removes_the_same_points_up_to_single_precision():
    points = single(5000)
    theirs = METHODS.get("meshlib_iterative")(points, 500, rng=rng()).indices
    ours = iterative_sampling(points, 500, rng=rng()).indices
    assert len(np.intersect1d(theirs, ours)) >= 0.97 * 500


@needs("vtk_poisson_disk")
def test_vtk_keeps_points_that_are_a_radius_apart():
    points = single(2000)
    kept = METHODS.get("vtk_poisson_disk")(points, 0, rng=rng(), radius=0.3).points
    assert cKDTree(kept).query(kept, 2)[0][:, 1].min() > 0.3 * (1 - 1e-6)
