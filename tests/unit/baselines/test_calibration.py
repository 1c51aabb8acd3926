"""The search for a radius or cell size: reaches what can be reached, bounded, repeatable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare_baselines._calibration import search_size, surface_spacing


def counter(law):
    calls = []

    def count(size):
        calls.append(size)
        return law(size)

    return count, calls


@given(st.integers(1, 30_000), st.floats(0.01, 100), st.floats(0.8, 4.5), st.floats(-5, 5, allow_nan=False))
def test_a_power_law_is_met_exactly_wherever_the_search_starts(target, scale, exponent, shift):
    def law(size):
        return min(round(1000 * (size / scale) ** -exponent), 10**9)

    start = scale * np.exp(shift)
    size = search_size(law, target, start, max_calls=80)
    assert law(size) == target


def test_a_target_between_two_steps_gives_the_nearer_step():
    count, calls = counter(lambda size: 100 if size < 1 else 40)
    assert count(search_size(count, 90, 5.0)) == 100
    assert count(search_size(count, 45, 5.0)) == 40
    assert len(calls) <= 2 * 60 + 2


def test_a_scattering_count_is_met_though_no_bracket_holds():
    rng = np.random.default_rng(0)
    count, calls = counter(lambda size: round(1000 / size**2 + rng.normal(0, 6)))
    seen = []
    size = search_size(lambda s: seen.append(count(s)) or seen[-1], 3000, 1.0, max_calls=80)
    assert seen[calls.index(size)] == 3000


def test_a_tolerance_ends_the_search_early():
    count, calls = counter(lambda size: round(1e6 / size**2))
    search_size(count, 3000, 1.0, tolerance=150)
    assert len(calls) <= 8


def test_the_calls_are_bounded_where_nothing_changes():
    count, calls = counter(lambda size: 7)
    search_size(count, 3, 1.0, max_calls=25)
    assert len(calls) == 25


@pytest.mark.parametrize(
    "points", [np.zeros((4, 3)), np.eye(3), np.outer(np.arange(5.0), [1, 0, 0]), np.eye(3) * 1e-9 + 4e6]
)
def test_the_first_guess_is_positive_on_every_cloud(points):
    assert surface_spacing(points, 2) > 0
