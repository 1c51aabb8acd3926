"""Cost per point of the filter and of its stages from ten thousand points to a million, and its memory."""

import json
import subprocess
import sys

import pytest

SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)

PROGRAM = """
import json, resource, sys, time
import numpy as np
import lpcompare

def wavy(n_points):
    points = np.random.default_rng(0).normal(size=(n_points, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * (1 + 0.2 * np.sin(5 * points[:, :1]) * np.cos(4 * points[:, 1:2]))

def sampled(path, n_points):
    points = np.load(path)
    return points[np.random.default_rng(0).choice(len(points), n_points, replace=False)]

n_points, path = int(sys.argv[1]), sys.argv[2]
points = sampled(path, n_points) if path else wavy(n_points)
lpcompare.simplify(wavy(3000), method="lp_density", target_reduction=0.9)
began = time.perf_counter()
result = lpcompare.simplify(points, method="lp_density", target_reduction=0.9)
print(json.dumps({
    "seconds": time.perf_counter() - began,
    "stages_us_per_point": {k: 1e6 * v / n_points for k, v in result.timings.items()},
    "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    "certified": result.info["n_certified"],
    "clusters": len(result.info["certificates"]),
}))
"""


def measure(n_points, path=""):
    """Run in a process of its own, so that the peak of memory is this run's."""
    command = [sys.executable, "-c", PROGRAM, str(n_points), str(path)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def report(benchmark, sizes, path=""):
    results = {}
    benchmark.pedantic(lambda: results.update({n: measure(n, path) for n in sizes}), rounds=1)
    for n_points, result in results.items():
        benchmark.extra_info[f"{n_points}"] = result | {"us_per_point": 1e6 * result["seconds"] / n_points}
        assert result["certified"] == result["clusters"]
    return results


def test_a_million_points(benchmark):
    results = report(benchmark, SIZES)
    per_point = {n: result["seconds"] / n for n, result in results.items()}
    assert per_point[1_000_000] < 1.5 * per_point[100_000]
    assert results[1_000_000]["peak_mib"] < 3 * 1024


def test_igea_at_growing_density(benchmark, shared_models, tmp_path):
    pymeshlab = pytest.importorskip("pymeshlab")
    import numpy as np

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(shared_models / "upstream" / "igea.ply"))
    points = meshes.current_mesh().vertex_matrix()
    np.save(tmp_path / "igea.npy", points)
    sizes = [n for n in SIZES if n <= len(points)]
    report(benchmark, [*sizes, len(points)], tmp_path / "igea.npy")
