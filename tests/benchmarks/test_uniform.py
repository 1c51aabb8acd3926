"""The parts of lp_uniform against the plain way to do each, and the whole against the paper's filter.

Run with ``pytest tests/benchmarks/test_uniform.py``; each pair is timed in turns, and the ratio of the
medians and, for the whole, the seconds of each stage stand in ``extra_info``.
"""

import statistics
import time
import warnings

import cvxpy as cp
import numpy as np
import pytest

import lpcompare
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import plane_distances
from lpcompare.uniform.neighborhoods import SIZES, Neighborhoods
from lpcompare.uniform.program import Stop, _Model, build_program, select_one_per_cell

N_POINTS, N_KEPT = 36_000, 7_200


@pytest.fixture(scope="module")
def cloud():
    u, v = np.random.default_rng(0).random((2, N_POINTS)) * 2 * np.pi
    ring = 1 + 0.4 * np.cos(v) + 0.02 * np.sin(20 * u)
    return np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)])


@pytest.fixture(scope="module")
def kept():
    return np.sort(np.random.default_rng(1).choice(N_POINTS, N_KEPT, replace=False))


def seconds(call):
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def compare(benchmark, ours, reference, repeats):
    """Time both in turns, report the ratio of the medians, and let the plug-in time ours as well."""
    ours()
    pairs = [(seconds(ours), seconds(reference)) for _ in range(repeats)]
    fast, slow = (statistics.median(column) for column in zip(*pairs, strict=True))
    benchmark.extra_info |= {"ours_s": fast, "reference_s": slow, "ratio": slow / fast}
    benchmark.pedantic(ours, rounds=3)
    return slow / fast


def test_nested_planes_against_one_call_per_size(benchmark, cloud, kept):
    nearest = Neighbors(cloud[kept]).query(cloud, max(SIZES))[1]
    rows = kept[nearest]
    ratio = compare(
        benchmark,
        lambda: plane_distances(cloud, cloud, rows, SIZES),
        lambda: [plane_distances(cloud, cloud, rows[:, :k]) for k in SIZES],
        repeats=5,
    )
    assert ratio > 1


def test_updated_neighbours_against_a_fresh_start(benchmark, cloud, kept):
    """A swap of 2 % of the kept points and back again."""
    tree = Neighbors(cloud)
    state = Neighborhoods(tree, kept)
    out, come = kept[::50], np.setdiff1d(np.arange(N_POINTS), kept)[: len(kept[::50])]

    def there_and_back():
        state.swap(out, come)
        state.swap(come, out)

    ratio = compare(benchmark, there_and_back, lambda: [Neighborhoods(tree, kept) for _ in range(2)], 5)
    assert ratio > 1.2


def test_program_from_its_start_against_cold_cvxpy(benchmark):
    rng = np.random.default_rng(0)
    cells = np.repeat(np.arange(300), 5)
    inverse = rng.random(1500) + 0.5
    costs, inverse = rng.random(1500) + 0.3 * inverse, inverse / inverse.mean()
    model = _Model(costs / costs.sum(), cells, np.argsort(cells, kind="stable"), inverse / 300, 0.01)

    def cold():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            build_program(model).solve(solver=cp.HIGHS, time_limit=10.0, mip_rel_gap=5e-3)

    ratio = compare(
        benchmark, lambda: select_one_per_cell(costs, cells, inverse, tolerance=0.01, stop=Stop()), cold, 3
    )
    assert ratio > 1


def test_whole_method_against_the_papers_filter(benchmark, cloud):
    """How much longer the uniform method takes than the density reading of the paper."""
    stages = lpcompare.simplify(cloud, target_count=N_KEPT, method="lp_uniform").timings
    benchmark.extra_info |= {f"{name}_s": spent for name, spent in stages.items()}
    compare(
        benchmark,
        lambda: lpcompare.simplify(cloud, target_count=N_KEPT, method="lp_uniform"),
        lambda: lpcompare.simplify(cloud, target_count=N_KEPT, method="lp_density"),
        repeats=3,
    )
