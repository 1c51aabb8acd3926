"""The parts of lp_uniform against the plain way to do each, and the whole against the paper's filter.

Run with ``pytest tests/benchmarks/test_uniform.py``; each pair is timed in turns, and the ratio of the
medians and, for the whole, the seconds of each stage stand in ``extra_info``.
"""

import statistics
import time
import warnings

import cvxpy as cp
import numpy as np
import pymeshlab
import pytest
from scipy.spatial import KDTree

import lpcompare
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import plane_distances
from lpcompare.geometry.surface import estimate_surface
from lpcompare.models import load_model
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
    normals = estimate_surface(tree).normals
    state = Neighborhoods(tree, normals, kept, 0.3)
    out, come = kept[::50], np.setdiff1d(np.arange(N_POINTS), kept)[: len(kept[::50])]

    def there_and_back():
        state.swap(out, come)
        state.swap(come, out)

    ratio = compare(
        benchmark, there_and_back, lambda: [Neighborhoods(tree, normals, kept, 0.3) for _ in range(2)], 5
    )
    assert ratio > 1.2


def test_program_from_its_start_against_cold_cvxpy(benchmark):
    rng = np.random.default_rng(0)
    cells = np.repeat(np.arange(300), 5)
    inverse = rng.random(1500) + 0.5
    costs, inverse = rng.random(1500) + 0.3 * inverse, inverse / inverse.mean()
    model = _Model(costs / costs.sum(), cells, 300, inverse / 300, 0.01)

    def cold():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            build_program(model).solve(solver=cp.HIGHS, time_limit=10.0, mip_rel_gap=5e-3)

    ratio = compare(
        benchmark, lambda: select_one_per_cell(costs, cells, inverse, tolerance=0.01, stop=Stop()), cold, 3
    )
    assert ratio > 1


def collapsed(cloud, faces, n_keep):
    """MeshLab's quadric edge collapse to about as many points, its mesh already loaded."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(cloud, faces))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=2 * n_keep)
    return meshes.current_mesh()


@pytest.mark.parametrize("reduction", [0.7, 0.8, 0.9])
def test_whole_method_against_meshlabs_quadric_collapse(benchmark, reduction):
    """On the bunny that pymeshlab carries; a ratio above 1 says that ours is faster."""
    bunny = load_model("bunny")
    n_keep = round((1 - reduction) * len(bunny))
    compare(
        benchmark,
        lambda: lpcompare.simplify(bunny.points, target_count=n_keep, method="lp_uniform"),
        lambda: collapsed(bunny.points, bunny.faces, n_keep),
        repeats=5,
    )


@pytest.mark.parametrize("n_points", [10_000, 100_000, 1_000_000, 4_000_000])
@pytest.mark.parametrize("method", ["lp_uniform", "lp_density"])
def test_cost_of_a_point_in_units_of_a_neighbor_pass(benchmark, n_points, method):
    """``unit_s`` builds a k-d tree and finds 16 neighbors of each point, on two workers, in random order."""
    u, v = np.random.default_rng(0).random((2, n_points)) * 2 * np.pi
    ring = 1 + 0.4 * np.cos(v) + 0.02 * np.sin(20 * u)
    cloud = np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)])
    unit = statistics.median(seconds(lambda: KDTree(cloud).query(cloud, 16, workers=2)) for _ in range(3))
    lpcompare.simplify(cloud[:3000], target_reduction=0.9, method=method)
    benchmark.pedantic(
        lambda: lpcompare.simplify(cloud, target_reduction=0.9, method=method),
        rounds=3 if n_points < 1_000_000 else 1,
    )
    took = benchmark.stats.stats.median if benchmark.stats else float("nan")
    benchmark.extra_info |= {"unit_s": unit, "units": took / unit, "us_per_point": 1e6 * took / n_points}


@pytest.mark.parametrize("method", ["lp_uniform", "lp_density", "random_sample"])
def test_tiles_against_the_whole_in_memory(benchmark, tmp_path, method):
    """A million points, from file to file: in 8 tiles, and as a whole; above 1 the tiles are faster."""
    u, v = np.random.default_rng(0).random((2, 1_000_000)) * 2 * np.pi
    ring = 1 + 0.4 * np.cos(v) + 0.02 * np.sin(20 * u)
    source, thin = tmp_path / "all.npy", tmp_path / "thin.npy"
    np.save(source, np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)]))

    def whole():
        cloud = lpcompare.read(source)
        result = lpcompare.simplify(cloud, target_reduction=0.9, method=method)
        lpcompare.write(thin, cloud.take(result.indices))

    def tiles():
        thin.unlink(missing_ok=True)
        lpcompare.simplify_files(source, thin, target_reduction=0.9, method=method, n_tiles=8)

    in_tiles, in_memory = seconds(tiles), seconds(whole)
    benchmark.extra_info |= {"ours_s": in_tiles, "reference_s": in_memory, "ratio": in_memory / in_tiles}
    benchmark.pedantic(tiles, rounds=1)
    assert len(np.load(thin)) == 100_000


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
