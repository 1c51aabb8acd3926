"""The smallest count within an error bound."""

import numpy as np
import pytest

import lpcompare
from lpcompare.errors import InputError
from lpcompare.metrics.comparison import Comparison
from lpcompare.metrics.plane_error import plane_error

CLOUD = np.random.default_rng(0).normal(size=(2000, 3))
CLOUD /= np.linalg.norm(CLOUD, axis=1)[:, None]


def error(reduced):
    return plane_error(Comparison(CLOUD, reduced))["plane_error_pct"]


@pytest.mark.parametrize("method", ["lp_uniform", "lp_density"])
@pytest.mark.parametrize("bound", [0.3, 1.0])
def test_the_bound_is_kept_and_a_few_points_less_would_break_it(method, bound):
    result = lpcompare.simplify(CLOUD, max_error=bound, method=method, n_clusters=5)
    assert error(result.points) <= bound
    diagonal = np.linalg.norm(np.ptp(CLOUD, axis=0))
    assert result.info["error"] == pytest.approx(error(result.points) * diagonal / 100)
    fewer = lpcompare.simplify(CLOUD, target_count=int(0.9 * len(result)), method=method, n_clusters=5)
    assert error(fewer.points) > bound


def test_a_tighter_bound_keeps_more_points():
    kept = [len(lpcompare.simplify(CLOUD, max_error=e, method="lp_uniform")) for e in (0.2, 0.4, 0.8)]
    assert kept[0] > kept[1] > kept[2]


def test_a_plane_needs_few_points_and_no_extent_needs_one():
    plane = np.random.default_rng(0).random((500, 3)) * [1, 1, 0]
    assert len(lpcompare.simplify(plane, max_error=1e-6, method="lp_uniform")) <= 12
    assert len(lpcompare.simplify(np.ones((30, 3)), max_error=0.0, method="lp_uniform")) == 1


def test_a_bound_below_the_clouds_own_error_is_refused():
    with pytest.raises(InputError, match="all 2000 points together"):
        lpcompare.simplify(CLOUD, max_error=1e-6, method="lp_uniform")


@pytest.mark.parametrize("target", [{"target_count": 10}, {"target_reduction": 0.5}])
def test_two_targets_are_refused(target):
    with pytest.raises(InputError, match="exactly one of target_reduction"):
        lpcompare.simplify(CLOUD, max_error=0.5, **target)


@pytest.mark.parametrize(("statistic", "of"), [("mean", np.mean), ("max", np.max)])
def test_a_tolerance_in_model_units_bounds_the_statistic_that_is_named(statistic, of):
    result = lpcompare.simplify(CLOUD, tolerance=0.02, statistic=statistic, method="farthest_point")
    assert of(Comparison(CLOUD, result.points).plane_errors(8)) <= 0.02
    assert len(result) < 2000


def test_the_error_of_moved_points_is_the_one_of_the_points_returned():
    result = lpcompare.simplify(CLOUD, max_error=0.5, method="lp_placed", n_clusters=5)
    assert error(result.points) <= 0.5
