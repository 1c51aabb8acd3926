"""Make the study of Pauly, Gross and Kobbelt (2002): measure into records.csv, and write README.md from it.

Run it from the root of the repository::

    python reports/pauly/make.py --models FOLDER

FOLDER holds the folders ``upstream`` and ``scans``. A case that records.csv already has from the same commit is not
made again. With ``--page`` nothing is measured.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Iterator
from pathlib import Path
from statistics import geometric_mean
from typing import Any

import numpy as np

import lpcompare as lp
from lpcompare.benchmark.environment import capture
from lpcompare.errors import NotApplicable
from lpcompare.mesh_library import pymeshlab
from lpcompare.metrics.comparison import Comparison
from lpcompare.metrics.mls_distance import mls_distances
from lpcompare.testing import sphere

HERE = Path(__file__).parent
RECORDS, MADE = HERE / "records.csv", HERE / "made.json"
FIGURE_13 = "igea", 5000
SHARE = 5000 / 134345
"""Share of the points that figure 13 keeps."""
SWEEP = (6, 8, 12, 16, 24)
FOUR = ("pauly_incremental", "pauly_hierarchical", "pauly_iterative", "pauly_particle")
SUBSETS = ("pauly_incremental_subset", "pauly_hierarchical_subset", "pauly_iterative_subset")
MESHED = ("quadric_collapse", "quadric_decimation")
OTHERS = ("lp_uniform", "lp_placed", *MESHED)
MODELS = {
    "igea": "upstream/igea.ply",
    "stanford-bunny": "upstream/stanford-bunny.obj",
    "fandisk": "upstream/fandisk.obj",
    "beast": "upstream/beast.obj",
    "nefertiti": "upstream/nefertiti.obj",
    "ogre": "upstream/ogre.obj",
    "lidar-room": "scans/lidar-room-56159.ply",
    "lidar-autzen": "scans/lidar-airborne-autzen-110000.ply",
}
LATER = (10000, 20000)
"""Counts at which the contraction of igea is measured too."""
MESH = "mesh of quadric_collapse"
"""A row of its own: the distance to the triangles themselves, not to a surface made from the points."""
PUBLISHED = {
    "pauly_incremental": 6.32e-4,
    "pauly_hierarchical": 6.14e-4,
    "pauly_iterative": 5.43e-4,
    "pauly_particle": 5.69e-4,
}
"""Mean error on David, 2,000,606 points to 5,000."""
COLUMNS = (
    "model", "method", "settings", "n_input", "target_count", "n_output", "runtime_s", "plane_error_pct",
    "mls_mean", "mls_max", *(f"mls_mean_k{k}" for k in SWEEP), "hausdorff_pct", "mesh_mean", "mesh_max",
)  # fmt: skip

Row = dict[str, Any]


def cases() -> Iterator[tuple[str, str, dict[str, Any], int | None]]:
    """Model, method, settings and count (None: the share of figure 13) of every case."""
    for method in (*FOUR, *SUBSETS, *OTHERS):
        yield "igea", method, {}, FIGURE_13[1]
    yield "igea", "pauly_particle", {"adaptive": True}, FIGURE_13[1]
    yield "igea", MESH, {}, FIGURE_13[1]
    for count in LATER:
        yield "igea", "pauly_iterative", {}, count
    for model in MODELS:
        if model != "igea":
            for method in (*FOUR, "lp_uniform", "lp_placed"):
                yield model, method, {}, None


def measure(cloud: lp.PointCloud, result: lp.Simplification, sweep: bool) -> Row:
    """The errors of a result, as shares of the diagonal where the publication has shares."""
    comparison = Comparison(cloud.points, result.points)
    distances = mls_distances(comparison) / comparison.diagonal
    row = {
        "n_output": len(result),
        "runtime_s": result.runtime_s,
        "plane_error_pct": comparison.plane_error_percent(),
        "hausdorff_pct": lp.evaluate(cloud, result)["hausdorff_pct"],
        "mls_mean": distances.mean(),
        "mls_max": distances.max(),
    }
    if sweep:
        row |= {f"mls_mean_k{k}": mls_distances(comparison, k).mean() / comparison.diagonal for k in SWEEP}
    return row


def mesh_distance(cloud: lp.PointCloud, target: int) -> Row:
    """Distance of the vertices to the triangles that MeshLab's quadric edge collapse leaves."""
    ml = pymeshlab()
    meshes = ml.MeshSet()
    for _ in range(2):
        meshes.add_mesh(ml.Mesh(cloud.points, cloud.faces.astype(np.int32)))  # pyright: ignore
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=2 * target - 4)
    found = meshes.get_hausdorff_distance(
        sampledmesh=0, targetmesh=1, samplevert=True, samplenum=len(cloud), maxdist=ml.PercentageValue(50)
    )
    diagonal = found["diag_mesh_0"]
    return {
        "n_output": meshes.current_mesh().vertex_number(),
        "mesh_mean": found["mean"] / diagonal,
        "mesh_max": found["max"] / diagonal,
    }


def read_records() -> list[Row]:
    """The rows that are there, numbers as numbers."""
    if not RECORDS.exists():
        return []
    with RECORDS.open(newline="", encoding="utf-8") as file:
        return [{k: _number(v) for k, v in row.items()} for row in csv.DictReader(file)]


def _number(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


def run(folder: Path) -> None:
    """Measure the cases that records.csv does not have, and add each as soon as it is there."""
    facts = capture((*FOUR, *OTHERS), 0)
    old = json.loads(MADE.read_text(encoding="utf-8"))["commit"] if MADE.exists() else ""
    if old.rstrip("+") != facts["commit"].rstrip(
        "+"
    ):  # what is written here makes the tree dirty, which is "+"
        RECORDS.unlink(missing_ok=True)  # of another commit
        MADE.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    done = {(r["model"], r["method"], r["settings"], int(r["target_count"])) for r in read_records()}
    clouds: dict[str, lp.PointCloud] = {}
    if not done:
        with RECORDS.open("w", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, COLUMNS).writeheader()
    for model, method, settings, count in cases():
        cloud = clouds.setdefault(model, lp.read(folder / MODELS[model]))
        target = count or round(SHARE * len(cloud))
        words = " ".join(f"{k}={v}" for k, v in settings.items())
        if (model, method, words, target) in done:
            continue
        row = {"model": model, "method": method, "settings": words, "n_input": len(cloud)}
        try:
            if method == MESH:
                row |= mesh_distance(cloud, target)
            else:
                # the first call compiles what is compiled
                lp.simplify(sphere(), target_count=50, method=method, **settings)
                result = lp.simplify(cloud, target_count=target, method=method, **settings)
                row |= measure(cloud, result, model == "igea")
        except NotApplicable:
            continue
        with RECORDS.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, COLUMNS).writerow(row | {"target_count": target})


def figure_13(rows: list[Row]) -> list[str]:
    """One line per method on igea, beside the publication's."""
    errors = "mean", "max", *(f"mean, k = {k}" for k in SWEEP)
    lines = _head("method", *errors, "eq. 27 [%]", "Hausdorff [%]", "seconds")
    lines.append(_line("published: iterative", "5.58e-05", "0.0011", *[""] * (len(SWEEP) + 2), "3.5"))
    lines.append(_line("published: QSlim on the mesh", "5.56e-05", "0.0012", *[""] * (len(SWEEP) + 2), "3.5"))
    for row in rows:
        if row["model"] == "igea" and row["target_count"] == FIGURE_13[1] and row["method"] != MESH:
            sweep = (f"{row[f'mls_mean_k{k}']:.2e}" for k in SWEEP)
            name = f"{row['method']} {row['settings']}".strip()
            cells = f"{row['plane_error_pct']:.4f}", f"{row['hausdorff_pct']:.2f}", f"{row['runtime_s']:.1f}"
            lines.append(
                _line(f"`{name}`", f"{row['mls_mean']:.2e}", f"{row['mls_max']:.4f}", *sweep, *cells)
            )
    return lines


def ratios(rows: list[Row]) -> list[str]:
    """One line per model: the mean error of each method over that of the incremental clustering."""
    methods = [*FOUR[1:], "lp_uniform", "lp_placed"]
    lines = _head("model", "points", "kept", *(f"`{m}`" for m in methods))
    printed = (f"{PUBLISHED[m] / PUBLISHED[FOUR[0]]:.2f}" if m in PUBLISHED else "" for m in methods)
    lines.append(_line("published: David", "2,000,606", "5,000", *printed))
    found: dict[str, list[float]] = {m: [] for m in methods}
    for model in MODELS:
        by = {r["method"]: r for r in rows if r["model"] == model and not r["settings"] and _figure_share(r)}
        if FOUR[0] not in by:
            continue
        values = {m: by[m]["mls_mean"] / by[FOUR[0]]["mls_mean"] for m in methods if m in by}
        for method, value in values.items():
            found[method].append(value)
        cells = (f"{values[m]:.2f}" if m in values else "-" for m in methods)
        n = by[FOUR[0]]["n_input"], by[FOUR[0]]["target_count"]
        lines.append(_line(model, *(f"{int(x):,}" for x in n), *cells))
    lines.append(
        _line("geometric mean", "", "", *(f"{geometric_mean(v):.2f}" if v else "-" for v in found.values()))
    )
    return lines


def _figure_share(row: Row) -> bool:
    return abs(row["target_count"] - SHARE * row["n_input"]) <= 1


def seconds(rows: list[Row]) -> list[str]:
    """One line per model: seconds of each of the four methods."""
    lines = _head("model", "points", "kept", *(f"`{m}`" for m in FOUR))
    for model in MODELS:
        by = {r["method"]: r for r in rows if r["model"] == model and not r["settings"] and _figure_share(r)}
        if all(m in by for m in FOUR):
            n = by[FOUR[0]]["n_input"], by[FOUR[0]]["target_count"]
            lines.append(
                _line(model, *(f"{int(x):,}" for x in n), *(f"{by[m]['runtime_s']:.1f}" for m in FOUR))
            )
    return lines


def _head(*titles: str) -> list[str]:
    return [_line(*titles), _line("---", *["---:"] * (len(titles) - 1))]


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def page(rows: list[Row]) -> str:
    """The text of README.md."""
    made = json.loads(MADE.read_text(encoding="utf-8"))
    igea = {
        (r["method"], int(r["target_count"])): r for r in rows if r["model"] == "igea" and not r["settings"]
    }
    ours, mesh = igea["pauly_iterative", 5000], igea[MESH, 5000]
    best = min(ours[f"mls_mean_k{k}"] for k in SWEEP)
    collapse = igea["quadric_collapse", 5000]
    later = "; ".join(f"{c:,} points {igea['pauly_iterative', c]['mls_mean_k8']:.2e}" for c in LATER)
    return (HERE / "page.md").read_text(encoding="utf-8").format(
        commit=made["commit"] or "unknown",
        started=made["started"],
        machine=f"{made['cpu']}, {made['cores_allowed']} cores, {made['os']}, Python {made['python']}",
        figure_13="\n".join(figure_13(rows)),
        ratios="\n".join(ratios(rows)),
        seconds="\n".join(seconds(rows)),
        best=f"{best:.2e}",
        times=f"{best / 5.58e-5:.1f}",
        mesh_mean=f"{mesh['mesh_mean']:.2e}",
        mesh_max=f"{mesh['mesh_max']:.4f}",
        mesh_times=f"{mesh['mesh_mean'] / 5.56e-5:.1f}",
        collapse_ratio=f"{ours['mls_mean_k8'] / collapse['mls_mean_k8']:.2f}",
        later=later,
    )  # fmt: skip


def main() -> None:
    """Measure what is missing, then write the page."""
    parser = argparse.ArgumentParser(description="Make the study of Pauly, Gross and Kobbelt (2002).")
    parser.add_argument("--models", type=Path, help="folder with upstream/ and scans/")
    parser.add_argument("--page", action="store_true", help="write README.md from the records alone")
    arguments = parser.parse_args()
    if not arguments.page:
        if arguments.models is None:
            parser.error("say --models FOLDER, or --page for the page alone")
        run(arguments.models)
    (HERE / "README.md").write_text(page(read_records()), encoding="utf-8")


if __name__ == "__main__":
    main()
