"""Farthest point sampling in buckets: as a ratio to the textbook loop, and on a million points."""

from statistics import median
from time import perf_counter

import numpy as np

from lpcompare_baselines._buckets import farthest_points


def ellipsoid(n):
    points = np.random.default_rng(0).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True) * [1, 2, 3]


def plain(points, target_count):
    nearest, taken = np.full(len(points), np.inf), [0]
    for _ in range(target_count - 1):
        nearest = np.minimum(nearest, np.square(points - points[taken[-1]]).sum(axis=1))
        taken.append(int(nearest.argmax()))
    return np.array(taken)


def timed(function, *arguments):
    start = perf_counter()
    return function(*arguments), perf_counter() - start


def test_ratio_to_the_textbook_loop(benchmark):
    points, ours, theirs = ellipsoid(30_000), [], []
    for _ in range(3):
        fast, time_ours = timed(farthest_points, points, 3_000, 0)
        slow, time_theirs = timed(plain, points, 3_000)
        assert np.array_equal(fast, slow)
        ours.append(time_ours)
        theirs.append(time_theirs)
    benchmark.extra_info["times_faster_than_the_textbook_loop"] = median(theirs) / median(ours)
    benchmark.pedantic(farthest_points, args=(points, 3_000, 0), rounds=3)


def test_a_million_points_to_a_tenth(benchmark):
    points = ellipsoid(1_000_000)
    taken = benchmark.pedantic(farthest_points, args=(points, 100_000, 0), rounds=1)
    assert len(np.unique(taken)) == 100_000
