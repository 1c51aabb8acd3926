"""Farthest point sampling in buckets against the plain algorithm."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lpcompare_baselines._buckets import farthest_points


def plain(points, target_count, first):
    """The textbook loop; a taken point is never taken again."""
    nearest, taken = np.full(len(points), np.inf), [first]
    while True:
        nearest = np.minimum(nearest, np.square(points - points[taken[-1]]).sum(axis=1))
        nearest[taken] = -1
        if len(taken) == target_count:
            return np.array(taken)
        taken.append(int(nearest.argmax()))


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10**6), st.integers(1, 2500), st.floats(0, 1), st.sampled_from(["ball", "lattice", "line"])
)
@example(49343, 1432, 1.0, "lattice")
def test_the_points_and_their_order_are_those_of_the_plain_algorithm(seed, n, share, kind):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    if kind == "lattice":
        points = np.round(2 * points)
    if kind == "line":
        points[:, 1:] = 0
    target = max(1, round(share * min(n, 400)))
    first = int(rng.integers(n))
    assert np.array_equal(farthest_points(points, target, first), plain(points, target, first))


@pytest.mark.parametrize(
    "points", [np.zeros((700, 3)), np.repeat(np.eye(3), 300, axis=0)], ids=["one", "three"]
)
def test_duplicates_are_taken_last_and_never_twice(points):
    taken = farthest_points(points, len(points), 5)
    assert np.array_equal(np.sort(taken), np.arange(len(points)))


def test_coordinates_of_a_survey_change_nothing():
    points = np.random.default_rng(0).normal(size=(2000, 3)).astype(np.float32).astype(float)
    far = np.round(points * 4096) / 4096 + [5e5, 4e6, 0.0]
    near = np.round(points * 4096) / 4096
    assert np.array_equal(farthest_points(near, 300, 0), farthest_points(far, 300, 0))
