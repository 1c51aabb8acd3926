"""Intervals and verdicts: what they promise, checked by simulation and by law."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare.report.statistics import LEVEL, holm, paired_difference, summarize, verdict

FINITE = st.floats(-1e6, 1e6)


@given(st.lists(FINITE, min_size=1, max_size=30))
def test_summary_is_ordered_and_holds_the_median(values):
    s = summarize(values)
    assert s.n == len(values)
    assert min(values) <= s.first_quartile <= s.median <= s.third_quartile <= max(values)
    if s.n >= 3:
        assert min(values) <= s.low <= s.median <= s.high <= max(values)
    else:
        assert math.isnan(s.low)


def test_bootstrap_interval_covers_the_median_about_as_often_as_it_says():
    rng = np.random.default_rng(0)
    draws = [summarize(rng.lognormal(size=25)) for _ in range(200)]
    covered = np.mean([s.low <= 1.0 <= s.high for s in draws])
    assert 0.88 <= covered <= 0.99


def test_false_alarms_stay_at_the_level_and_a_fifth_more_is_found():
    rng = np.random.default_rng(1)
    margin = math.log(1.05)

    def calls(true_ratio):
        draws = rng.normal(math.log(true_ratio), 0.08, size=(400, 12))
        return np.mean([paired_difference(d, margin).p_value < LEVEL for d in draws])

    assert calls(1.0) <= LEVEL
    assert calls(1.05) <= LEVEL + 0.03
    assert calls(1.2) > 0.95


def test_without_a_margin_the_level_is_exact():
    draws = np.random.default_rng(2).normal(size=(2000, 8))
    assert np.mean([paired_difference(d).p_value < LEVEL for d in draws]) == pytest.approx(LEVEL, abs=0.015)


def test_equal_pairs_are_no_difference_and_constant_ones_are():
    assert paired_difference([0.0] * 5).p_value == 1.0
    assert paired_difference([0.3] * 5).p_value == 0.0
    assert paired_difference([0.03] * 5, margin=0.05).p_value == 1.0


def test_one_pair_says_nothing():
    single = paired_difference([3.0])
    assert single.p_value == 1.0
    assert verdict(single, single.p_value, "more", "less") == "too few pairs"
    assert verdict(None, 1.0, "more", "less") == "too few pairs"


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_never_lowers_a_p_value_and_keeps_their_order(p_values):
    adjusted = holm(p_values)
    assert all(0 <= p <= a <= 1 for p, a in zip(p_values, adjusted, strict=True))
    order = np.argsort(p_values, kind="stable")
    assert (np.diff(np.array(adjusted)[order]) >= 0).all()
    assert min(adjusted) == pytest.approx(min(1.0, len(p_values) * min(p_values)))


def test_holm_agrees_with_a_worked_example():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
