"""Medians and their intervals: what they promise, checked by simulation and by law."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lpcompare.report.statistics import summarize

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
