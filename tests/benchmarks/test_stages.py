"""How long each stage of our methods takes on the bunny thinned to a tenth.

Stages that end with kept points carry the eq. 27 error of these in ``extra_info``.
"""

import numpy as np
import pytest

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import normalize
from lpcompare.geometry.surface import estimate_surface
from lpcompare.metrics.comparison import Comparison
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import estimate_curvature
from lpcompare.paper.features import feature_mask
from lpcompare.paper.program import SolverSettings
from lpcompare.paper.reduction import Reading, plan_clusters, reduce_clusters
from lpcompare.uniform.clusters import (
    cluster_densities,
    refine_in_density,
    solve_programs,
    spread_points,
)
from lpcompare.uniform.program import Stop
from lpcompare.uniform.quadrics import place_points
from lpcompare.uniform.rims import find_rims
from lpcompare.uniform.swaps import EMPHASES

N_CLUSTERS, SHARE_KEPT, N_ROUNDS, TOLERANCE = 20, 0.1, 6, 0.05


@pytest.fixture(scope="module")
def tree():
    from lpcompare.models import load_model

    return Neighbors(normalize(load_model("bunny").points)[0])


@pytest.fixture(scope="module")
def cloud(tree):
    return tree.sorted_points


@pytest.fixture(scope="module")
def n_keep(cloud):
    return int(SHARE_KEPT * len(cloud))


@pytest.fixture(scope="module")
def labels(cloud):
    return cluster_points(cloud, N_CLUSTERS, np.random.default_rng(0)).labels


@pytest.fixture(scope="module")
def curvature(cloud):
    return estimate_curvature(cloud).absolute


@pytest.fixture(scope="module")
def surface(tree):
    return estimate_surface(tree)


@pytest.fixture(scope="module")
def density(cloud, labels):
    return cluster_densities(cloud, labels)


@pytest.fixture(scope="module")
def rims(cloud, surface, n_keep):
    return find_rims(cloud, surface, n_keep)


@pytest.fixture(scope="module")
def spread(tree, surface, rims, curvature, density, n_keep):
    return spread_points(tree, surface, rims, curvature, density, n_keep)


@pytest.fixture(scope="module")
def refined(tree, surface, spread, density):
    return swapped(tree, surface, spread, density)


def swapped(tree, surface, spread, density):
    settings = {"n_rounds": N_ROUNDS, "tolerance": TOLERANCE, "emphasis": EMPHASES["balanced"]}
    return refine_in_density(tree, surface, spread, density, **settings)


def timed(benchmark, stage):
    return benchmark.pedantic(stage, rounds=5, warmup_rounds=1)


def judge(benchmark, cloud, kept):
    comparison = Comparison(cloud, kept)
    error = comparison.plane_error_percent()
    benchmark.extra_info |= {"n_output": len(kept), "plane_error_pct": error}
    assert np.isfinite(error)


def test_clustering(benchmark, cloud):
    mixture = timed(benchmark, lambda: cluster_points(cloud, N_CLUSTERS, np.random.default_rng(0)))
    assert len(mixture.labels) == len(cloud)


def test_curvature(benchmark, cloud):
    assert len(timed(benchmark, lambda: estimate_curvature(cloud)).absolute) == len(cloud)


@pytest.mark.parametrize("method", ["lp_printed", "lp_density"])
def test_selection(benchmark, cloud, labels, curvature, n_keep, method):
    def select():
        rng = np.random.default_rng(0)
        features = feature_mask(curvature, labels)
        tasks = plan_clusters(cloud, labels, features, curvature, target_count=n_keep, rng=rng)
        return reduce_clusters(cloud, tasks, Reading(method), SolverSettings())

    judge(benchmark, cloud, cloud[timed(benchmark, select)[0]])


def test_surface(benchmark, tree):
    assert len(timed(benchmark, lambda: estimate_surface(tree)).areas) == len(tree.points)


def test_rims(benchmark, cloud, surface, n_keep):
    assert timed(benchmark, lambda: find_rims(cloud, surface, n_keep))


def test_cells(benchmark, tree, cloud, surface, rims, curvature, density, n_keep):
    spread = timed(benchmark, lambda: spread_points(tree, surface, rims, curvature, density, n_keep))
    judge(benchmark, cloud, cloud[spread])


def test_swaps(benchmark, tree, cloud, surface, density, spread):
    refined = timed(benchmark, lambda: swapped(tree, surface, spread, density))
    judge(benchmark, cloud, cloud[refined])


def test_programs(benchmark, cloud, surface, rims, density, refined):
    def solve():
        return solve_programs(cloud, surface, rims, density, refined, tolerance=TOLERANCE, stop=Stop())

    judge(benchmark, cloud, cloud[timed(benchmark, solve)[0]])


def test_placement(benchmark, tree, cloud, surface, rims, refined):
    judge(benchmark, cloud, timed(benchmark, lambda: place_points(tree, surface, rims, refined)))
