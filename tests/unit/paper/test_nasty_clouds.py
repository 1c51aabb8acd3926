"""Clouds that are legal and break programs: each has its expected outcome, and none may warn."""

from functools import partial

import numpy as np
import pytest

import lpcompare
from lpcompare.errors import InputError
from lpcompare.estimators import LPSimplifier

simplify = partial(lpcompare.simplify, method="lp_density")

RNG = np.random.default_rng(0)
CLOUD = RNG.normal(size=(400, 3))
SURFACE = np.column_stack([CLOUD[:, :2], np.sin(2 * CLOUD[:, 0]) * 0.3])
MILLIMETRES = np.column_stack([RNG.uniform(0, 0.5, (400, 2)), RNG.uniform(0, 0.05, 400)])
OUTLIERS = np.vstack([SURFACE[:380], RNG.uniform(-50, 50, (20, 3))])
BLOBS = np.vstack([CLOUD[:200] * 1e-3, CLOUD[200:] * 1e-3 + 1e6])
CENTRED = np.vstack([np.zeros(3), np.eye(3), -np.eye(3), 2 * np.eye(3), -2 * np.eye(3)])
HALF_EDGE = np.column_stack([np.linspace(-1, 1, 300), np.zeros(300), np.r_[np.zeros(297), [5.0, 6, 7]]])

# name: points, target_count, points that stay, settings
TABLE = {
    "one point": (CLOUD[:1], 1, 1, {}),
    "two points": (CLOUD[:2], 1, 1, {}),
    "three points": (CLOUD[:3], 2, 2, {}),
    "all equal": (np.ones((50, 3)), 7, 7, {}),
    "all equal far from the origin": (np.full((50, 3), 4e6 + 0.1), 7, 7, {}),
    "ten of each": (np.repeat(CLOUD[:20], 10, axis=0), 37, 37, {}),
    "half duplicates": (np.vstack([CLOUD, CLOUD]), 300, 300, {}),
    "one place and one stray": (np.vstack([np.zeros((60, 3)), [[1.0, 2, 3]]]), 11, 11, {}),
    "collinear": (np.outer(np.linspace(0, 1, 300), [1.0, 2, -1]), 33, 33, {}),
    "collinear along an axis": (np.outer(np.arange(100.0), [0, 0, 1]), 10, 10, {}),
    "coplanar": (CLOUD * [1, 1, 0], 41, 41, {}),
    "coplanar and oblique": ((CLOUD * [1, 1, 0]) @ np.linalg.qr(CLOUD[:3])[0], 41, 41, {}),
    "grid": (np.stack(np.meshgrid(*[np.arange(7.0)] * 3), axis=-1).reshape(-1, 3), 100, 100, {}),
    "point on its centroid": (CENTRED, 5, 5, {"n_clusters": 1}),
    "clusters smaller than the neighbourhood": (CLOUD[:60], 20, 20, {"n_clusters": 30}),
    "neighbourhood larger than the cloud": (CLOUD[:30], 9, 9, {"n_neighbors": 500}),
    "one neighbour": (CLOUD, 50, 50, {"n_neighbors": 1}),
    "two neighbours": (CLOUD, 50, 50, {"n_neighbors": 2}),
    "a sharp corner on a line": (HALF_EDGE, 30, 30, {"n_clusters": 4}),
    "budget of zero in most clusters": (CLOUD, 2, 2, {"n_clusters": 20}),
    "budget of all points": (CLOUD, 400, 400, {}),
    "all but one": (CLOUD, 399, 399, {}),
    "features fill the budget": (SURFACE, 100, 100, {"feature_share": 1.0}),
    "no share for features": (SURFACE, 100, 100, {"feature_share": 0.0}),
    "more clusters than points": (CLOUD[:9], 4, 4, {"n_clusters": 50}),
    "as many clusters as points": (CLOUD[:9], 4, 4, {"n_clusters": 9}),
    "one cluster": (CLOUD, 100, 100, {"n_clusters": 1}),
    "two blobs far apart": (BLOBS, 80, 80, {}),
    "UTM with millimetres": (MILLIMETRES + np.array([5e5, 4e6, 120.0]), 80, 80, {}),
    "scale 1e-9": (SURFACE * 1e-9, 80, 80, {}),
    "scale 1e9": (SURFACE * 1e9, 80, 80, {}),
    "scale 1e-140": (SURFACE * 1e-140, 80, 80, {}),
    "scale 1e140": (SURFACE * 1e140, 80, 80, {}),
    "float32": (SURFACE.astype(np.float32), 80, 80, {}),
    "integers": (RNG.integers(-50, 50, (400, 3)), 80, 80, {}),
    "Fortran order": (np.asfortranarray(SURFACE), 80, 80, {}),
    "a list": (SURFACE.tolist(), 80, 80, {}),
    "every second row": (SURFACE[::2], 80, 80, {}),
    "5 % outliers": (OUTLIERS, 80, 80, {}),
    "one point at infinity, nearly": (np.vstack([SURFACE, [[1e12, 0, 0]]]), 80, 80, {}),
}


@pytest.mark.parametrize("method", ["lp_density", "lp_printed"])
@pytest.mark.parametrize("name", TABLE)
def test_exactly_the_target_stays(name, method):
    points, target, expected, settings = TABLE[name]
    result = simplify(points, target_count=target, method=method, **settings)
    check(result, points, expected)
    assert result.info["n_certified"] == len(result.info["certificates"])


@pytest.mark.parametrize("name", TABLE)
def test_all_features_stay(name):
    points, target, _, settings = TABLE[name]
    simplifier = LPSimplifier(target_count=target, retention="keep-features", **settings).fit(points)
    features = int(simplifier.feature_mask_.sum())
    check(simplifier.simplification_, points, features + target * (len(points) - features) // len(points))
    assert np.isin(np.flatnonzero(simplifier.feature_mask_), simplifier.sample_indices_).all()


@pytest.mark.parametrize("settings", [{"density": "printed"}, {"solver": "highs-cold"}])
@pytest.mark.parametrize("name", ["one point", "all equal", "collinear", "coplanar", "point on its centroid"])
def test_other_settings_survive_degenerate_clouds(name, settings):
    points, target, expected, more = TABLE[name]
    result = simplify(points, target_count=target, **{"n_clusters": 3} | more | settings)
    check(result, points, expected)


@pytest.mark.parametrize("method", ["lp_density", "lp_printed"])
@pytest.mark.parametrize("scale", [1e-149, 1e-20, 1e-9, 1e9, 1e20, 1e149])
def test_the_printed_density_depends_on_the_unit_and_survives_any(scale, method):
    points = SURFACE / np.abs(SURFACE).max() * scale
    result = simplify(points, target_count=80, method=method, density="printed", n_clusters=5)
    check(result, points, 80)
    assert result.info["n_certified"] == 5


def check(result, points, expected):
    assert len(result) == len(result.indices) == expected
    assert (np.diff(result.indices) > 0).all()
    assert np.array_equal(result.points, np.asarray(points, dtype=float)[result.indices])


def test_a_cluster_of_only_features_keeps_them_all():
    from lpcompare.paper.program import SolverSettings
    from lpcompare.paper.reduction import Reading, plan_clusters, reduce_clusters

    labels, features = np.repeat([0, 1], 200), np.repeat([True, False], 200)
    tasks = plan_clusters(
        CLOUD,
        labels,
        features,
        np.linspace(2, 1, 400),
        target_count=100,
        rng=np.random.default_rng(0),
        retention="keep-features",
    )
    indices, certificates = reduce_clusters(CLOUD, tasks, Reading(), SolverSettings())
    assert len(indices) == 200 + 50
    assert [c.proof for c in certificates] == ["counting", "zero"]


def test_read_only_arrays_are_left_alone():
    points = SURFACE.copy()
    points.flags.writeable = False
    check(simplify(points, target_count=80), SURFACE, 80)


@pytest.mark.parametrize("scale", [1e200, 1e-200, 1e-310])
def test_coordinates_whose_squares_leave_the_float_range_are_refused(scale):
    with pytest.raises(InputError, match="rescale"):
        simplify(SURFACE * scale, target_count=80)
