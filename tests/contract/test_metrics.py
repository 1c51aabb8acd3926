"""What every metric found must keep: its columns, zero for identity, invariance."""

import math

import numpy as np
import pytest

from lpcompare.metrics.comparison import Comparison
from lpcompare.registry import METRICS


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
    for column in METRICS.module(name).COLUMNS.values():
        assert column.title
        assert column.better in ("lower", "higher")


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
    tolerance = 0.06 if name == "surface_distance" else 0.02
    relative = 4.0 * still.diagonal / other.diagonal
    factors = {"% of diagonal": relative, "model units": 4.0, "square model units": 16.0}
    for key, column in METRICS.module(name).COLUMNS.items():
        expected = before[key] * factors.get(column.unit, 1.0)
        if column.unit == "dB":
            expected -= 20 * math.log10(relative)
        assert after[key] == pytest.approx(expected, rel=tolerance, abs=1e-9), key


@pytest.mark.parametrize("name", METRICS.names())
def test_clouds_without_extent_do_not_break(name):
    same = np.zeros((5, 3))
    values = METRICS.get(name)(Comparison(same, same[:1]))
    assert not any(math.isinf(v) for v in values.values())
