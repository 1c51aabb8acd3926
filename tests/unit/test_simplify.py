"""The public function: any cloud, any method, one way to say how far."""

import numpy as np
import pytest

import lpcompare
from lpcompare.errors import InputError, Unavailable, UnknownName
from lpcompare.registry import METHODS
from lpcompare.types import PointCloud

POINTS = np.random.default_rng(0).normal(size=(300, 3))


def test_the_default_is_lp_uniform():
    result = lpcompare.simplify(POINTS, target_reduction=0.9)
    assert result.method == "lp_uniform"
    assert len(result) == 30
    assert np.array_equal(result.points, POINTS[result.indices])


@pytest.mark.parametrize("method", [n for n in METHODS if not METHODS.missing(n)])
def test_every_method_takes_an_array_or_a_cloud_with_the_same_result(method):
    if METHODS.traits(method).needs_mesh:
        with pytest.raises(InputError, match="mesh"):
            lpcompare.simplify(POINTS, target_count=30, method=method)
        return
    of_array = lpcompare.simplify(POINTS, target_count=30, method=method)
    of_cloud = lpcompare.simplify(PointCloud(POINTS, name="scan"), target_count=30, method=method)
    assert len(of_array) == len(of_cloud)
    assert not METHODS.traits(method).repeatable or np.array_equal(of_array.points, of_cloud.points)
    assert of_array.runtime_s >= 0
    assert set(of_array.settings) == set(METHODS.settings(method))


@pytest.mark.parametrize("blank", [np.nan, np.inf])
def test_points_without_coordinates_are_refused_or_left_out(blank):
    holed = POINTS.copy()
    holed[[3, 7], 1] = blank
    with pytest.raises(InputError, match="drop_invalid=True"):
        lpcompare.simplify(holed, target_count=30, method="farthest_point")
    result = lpcompare.simplify(holed, target_count=30, method="farthest_point", drop_invalid=True)
    assert result.info["n_left_out"] == 2
    assert np.array_equal(result.points, holed[result.indices])
    assert not {3, 7} & set(result.indices.tolist())


def test_masked_points_count_as_missing():
    mask = np.zeros((300, 3), dtype=bool)
    mask[5, 0] = True
    masked = np.ma.MaskedArray(POINTS, mask)
    with pytest.raises(InputError, match="masked"):
        lpcompare.simplify(masked, target_count=30, method="random_sample")
    result = lpcompare.simplify(masked, target_count=299, method="random_sample", drop_invalid=True)
    assert 5 not in result.indices


def test_a_transposed_array_is_refused_with_the_remedy():
    with pytest.raises(InputError, match=r"\(3, 300\).*\.T"):
        lpcompare.simplify(POINTS.T, target_count=1)


def test_a_cloud_of_nothing_but_missing_points():
    with pytest.raises(InputError, match="nothing is left"):
        lpcompare.simplify(np.full((4, 3), np.nan), target_count=1, drop_invalid=True)


@pytest.mark.parametrize(
    ("arguments", "error", "says"),
    [
        ({"method": "lp_unifrom"}, UnknownName, "Did you mean 'lp_uniform'"),
        ({"n_clustrs": 4}, UnknownName, "Did you mean 'n_clusters'"),
        ({"n_clusters": "many"}, InputError, "n_clusters is 'many', a str"),
        ({"n_clusters": -3}, InputError, "n_clusters is -3"),
        ({"random_state": -1}, InputError, "random_state is -1"),
        ({"random_state": "x"}, InputError, "random_state is 'x'"),
        ({"target_reduction": 0.5}, InputError, "exactly one of target_reduction"),
    ],
)
@pytest.mark.parametrize("method", ["lp_uniform", "lp_density"])
def test_wrong_arguments_are_one_sentence(arguments, error, says, method):
    with pytest.raises(error, match=says):
        lpcompare.simplify(POINTS, **({"target_count": 30, "method": method} | arguments))


def test_a_missing_package_is_said_with_its_install_line():
    absent = [n for n in METHODS if METHODS.missing(n) and METHODS.traits(n).extra]
    if not absent:
        pytest.skip("every optional rival is installed")
    with pytest.raises(Unavailable, match="pip install"):
        lpcompare.simplify(POINTS, target_count=30, method=absent[0])


def test_stages_are_reported():
    stages = []
    lpcompare.simplify(POINTS, target_count=30, callback=lambda *event: stages.append(event[0]))
    assert "selection" in stages


def test_a_child_process_gives_the_same_points():
    from lpcompare.benchmark.isolation import Limits

    here = lpcompare.simplify(POINTS, target_count=30, method="lp_density", random_state=4)
    there = lpcompare.simplify(POINTS, target_count=30, method="lp_density", random_state=4, limits=Limits())
    assert np.array_equal(here.points, there.points)
    assert np.array_equal(here.info["labels"], there.info["labels"])


def test_repr_is_a_line():
    assert repr(PointCloud(POINTS, name="a")) == "PointCloud('a': 300 points)"
    assert repr(lpcompare.simplify(POINTS, target_count=3, method="random_sample")).startswith(
        "Simplification(random_sample: 3 points of the input, "
    )
