"""What every metric found must keep: its columns, zero for identity, invariance."""

import math
from itertools import combinations

import numpy as np
import pytest

from lpcompare.metrics.comparison import Comparison, evaluate
from lpcompare.registry import METRICS
from lpcompare.types import PointCloud, Simplification


@pytest.fixture(scope="module")
def sphere():
    points = np.random.default_rng(5).normal(size=(800, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.mark.parametrize("name", METRICS.names())
def test_values_are_finite_and_are_the_columns_declared(name, sphere):
    values = METRICS.get(name)(Comparison(sphere, sphere[::4]))
    assert values.keys() == METRICS.module(name).COLUMNS.keys()
    assert all(isinstance(v, float) and math.isfinite(v) for v in values.values())


@pytest.mark.parametrize("name", METRICS.names())
def test_columns_say_unit_and_direction(name):
    assert METRICS.columns(name) == METRICS.module(name).COLUMNS
    for column in METRICS.columns(name).values():
        assert column.title
        assert column.better in ("lower", "higher")


def test_an_alias_names_a_column_that_stands_for_itself():
    columns = {key: c for name in METRICS for key, c in METRICS.module(name).COLUMNS.items()}
    aliases = {c.alias for c in columns.values() if c.alias}
    assert aliases
    assert all(alias in columns and not columns[alias].alias for alias in aliases)


@pytest.mark.parametrize("kind", ["subset", "moved"])
def test_no_two_witnesses_give_the_same_number(kind, sphere):
    """On a cloud whose values are all different, equal columns are equal by definition."""
    rng = np.random.default_rng(0)
    cloud = np.concatenate([sphere * [1.0, 0.7, 0.4], 0.2 * rng.normal(size=(300, 3))])
    reduced = cloud[::4] if kind == "subset" else cloud[::4] * 1.01 + 0.003 * rng.normal(size=(275, 3))
    comparison = Comparison(cloud, reduced)
    values = {
        key: value
        for name in METRICS
        for key, value in METRICS.get(name)(comparison).items()
        if not METRICS.module(name).COLUMNS[key].alias and value != 0
    }
    for (first, a), (second, b) in combinations(values.items(), 2):
        assert a != pytest.approx(b, rel=1e-9), (first, second)


@pytest.mark.parametrize("name", METRICS.names())
def test_relative_values_do_not_change_under_rigid_motion_and_scale(name, sphere):
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    moved = 4.0 * sphere @ turn.T + [10.0, -20.0, 5.0]
    # the bounding box is not rotation invariant, so compare lengths through its diagonal
    still = Comparison(sphere, sphere[::4])
    other = Comparison(moved, moved[::4])
    before, after = METRICS.get(name)(still), METRICS.get(name)(other)
    # a triangulation depends on where it begins, and that on the axes
    tolerance = 0.06 if name == "pivoted_distance" else 0.02
    relative = 4.0 * still.diagonal / other.diagonal
    factors = {"% of diagonal": relative, "model units": 4.0, "square model units": 16.0}
    for key, column in METRICS.module(name).COLUMNS.items():
        expected = before[key] * factors.get(column.unit, 1.0)
        if column.unit == "dB":
            expected -= 20 * math.log10(relative)
        assert after[key] == pytest.approx(expected, rel=tolerance, abs=1e-9), key


def test_evaluate_gives_every_quick_column_of_records_and_of_arrays(sphere):
    cloud, kept = PointCloud(sphere), np.arange(0, 800, 4)
    values = evaluate(cloud, Simplification(sphere[kept], kept))
    assert values == evaluate(sphere, sphere[kept])
    quick = [name for name in METRICS if getattr(METRICS.module(name), "COST", "") != "slow"]
    assert "pivoted_distance" not in quick
    assert values.keys() == {key for name in quick for key in METRICS.module(name).COLUMNS}


@pytest.mark.parametrize("name", METRICS.names())
def test_clouds_without_extent_do_not_break(name):
    same = np.zeros((5, 3))
    values = METRICS.get(name)(Comparison(same, same[:1]))
    assert not any(math.isinf(v) for v in values.values())
