"""Every stage and the whole filter against the same method built from public parts.

The reference is scikit-learn's GaussianMixture with its defaults, curvature in batched numpy, and cvxpy's
plain call of HiGHS, which may take half a minute per cluster. Each pair is timed in turns, and the ratio of
the medians stands in ``extra_info``. Run with ``pytest tests/benchmarks/test_lp_filter.py``.
"""

import statistics
import time
import tracemalloc

import numpy as np
import pytest
from scipy.spatial import KDTree
from sklearn.mixture import GaussianMixture

import lpcompare
from lpcompare.geometry.scale import normalize
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import estimate_curvature
from lpcompare.paper.features import feature_mask
from lpcompare.paper.program import SolverSettings
from lpcompare.paper.reduction import Reading, plan_clusters, reduce_clusters

N_CLUSTERS, REDUCTION = 20, 0.9
COLD_TIME_LIMIT = 30.0


def read_vertices(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)


@pytest.fixture(scope="module")
def bunny(shared_models):
    return read_vertices(shared_models / "upstream" / "stanford-bunny.obj")


@pytest.fixture(scope="module")
def cloud(bunny):
    return normalize(bunny)[0]


def reference_clusters(points):
    return GaussianMixture(N_CLUSTERS, random_state=0).fit_predict(points)


def reference_curvature(points, n_neighbors=20):
    """A of eq. 11 by one batched least-squares quadric per point, in plain numpy."""
    neighborhoods = points[KDTree(points).query(points, n_neighbors)[1]] - points[:, None]
    centred = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(centred.transpose(0, 2, 1) @ centred)[1]
    w, u, v = np.moveaxis(neighborhoods @ axes, 2, 0)
    basis = np.stack([np.ones_like(u), u, v, u * u / 2, u * v, v * v / 2], axis=2)
    _, p, q, r, s, t = (np.linalg.pinv(basis) @ w[:, :, None])[:, :, 0].T
    steep = 1 + p * p + q * q
    mean = ((1 + q * q) * r - 2 * p * q * s + (1 + p * p) * t) / (2 * steep**1.5)
    spread = np.sqrt(np.maximum(mean**2 - (r * t - s * s) / steep**2, 0))
    return 2 * np.maximum(np.abs(mean), spread)


def tasks_of(cloud, labels, curvature):
    return plan_clusters(
        cloud,
        labels,
        feature_mask(curvature, labels),
        curvature,
        target_count=round((1 - REDUCTION) * len(cloud)),
        rng=np.random.default_rng(0),
    )


def reduced(cloud, tasks, solver):
    return reduce_clusters(cloud, tasks, Reading(), SolverSettings(solver, COLD_TIME_LIMIT))[1]


def reference_filter(points):
    cloud = normalize(points)[0]
    labels, curvature = reference_clusters(cloud), reference_curvature(cloud)
    return reduced(cloud, tasks_of(cloud, labels, curvature), "highs-cold")


def seconds(call):
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def compare(benchmark, ours, reference, repeats):
    """Time ours before and after each run of the reference and report the ratio of the medians and the peaks.

    The peak is that of Python's allocations, numpy's arrays among them, measured in a run of its own.
    """
    ours()
    fast, slow = [], []
    for _ in range(repeats):
        fast += [seconds(ours), seconds(ours)]
        slow.append(seconds(reference))
        fast += [seconds(ours), seconds(ours)]
    ratio = statistics.median(slow) / statistics.median(fast)
    benchmark.extra_info |= {"ours_s": fast, "reference_s": slow, "ratio": ratio, "peak_mib": peak_mib(ours)}
    benchmark.pedantic(ours, rounds=3)
    return ratio


def peak_mib(call):
    tracemalloc.start()
    call()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 2**20


def test_clustering_against_scikit_learn(benchmark, cloud):
    ratio = compare(
        benchmark,
        lambda: cluster_points(cloud, N_CLUSTERS, np.random.default_rng(0)),
        lambda: reference_clusters(cloud),
        repeats=3,
    )
    assert ratio > 5


def test_curvature_against_batched_numpy(benchmark, cloud):
    ratio = compare(benchmark, lambda: estimate_curvature(cloud), lambda: reference_curvature(cloud), 3)
    assert ratio > 2


def test_selection_against_cold_highs(benchmark, cloud):
    mixture = cluster_points(cloud, N_CLUSTERS, np.random.default_rng(0))
    tasks = tasks_of(cloud, mixture.labels, estimate_curvature(cloud).absolute)
    cold = []
    ratio = compare(
        benchmark,
        lambda: reduced(cloud, tasks, "highs"),
        lambda: cold.extend(reduced(cloud, tasks, "highs-cold")),
        repeats=1,
    )
    benchmark.extra_info["cold_at_the_time_limit"] = sum(c.status != "optimal" for c in cold)
    assert ratio > 100


def test_whole_filter_against_the_reference(benchmark, bunny):
    ratio = compare(
        benchmark,
        lambda: lpcompare.simplify(
            bunny, method="lp_density", target_reduction=REDUCTION, n_clusters=N_CLUSTERS
        ),
        lambda: reference_filter(bunny),
        repeats=1,
    )
    assert ratio > 50
