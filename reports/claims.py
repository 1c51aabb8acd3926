"""The README's table of claims, from the committed files alone.

Run it from the root of the repository: ``python reports/claims.py``. A test holds the README against it.
"""

from __future__ import annotations

import csv
import json
import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import geometric_mean

FOLDER = Path(__file__).resolve().parent
MESH_RIVALS = ("quadric_collapse", "quadric_decimation")

Row = dict[str, str]


def read(name: str) -> list[Row]:
    """The rows of a committed CSV file."""
    with (FOLDER / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def column(rows: list[Row], name: str, **wanted: str) -> list[float]:
    """One column of the rows that match, as numbers."""
    return [float(r[name]) for r in rows if all(r[k] == v for k, v in wanted.items())]


def uniform() -> Iterator[tuple[str, str, str]]:
    """What `lp_uniform` and `lp_placed` reach."""
    study = runpy.run_path(str(FOLDER / "uniform" / "ratios.py"))
    cases = study["read"](FOLDER / "uniform" / "records.csv")
    source = "[uniform](reports/uniform/README.md)"
    for method, what in (("lp_uniform", "a subset of the raw points"), ("lp_placed", "its points moved")):
        found = study["ratios"](cases, method).values()
        ratios, surface = ([r[k] for r in found] for k in ("plane_error_pct", "surface_distance_pct"))
        yield (
            f"`{method}`, {what}: eq. 27 error as a multiple of Poisson disk sampling's at equal counts",
            f"{geometric_mean(ratios):.2f} over {len(ratios)} cases, worst {max(ratios):.2f}; "
            f"triangulated surface {geometric_mean(surface):.2f}",
            source,
        )
    rivals = {m: study["ratios"](cases, "lp_uniform", m).values() for m in MESH_RIVALS}
    wins = {m: [r["plane_error_pct"] < 1 for r in found] for m, found in rivals.items()}
    told = "; ".join(f"{sum(won)} of {len(won)} ({m})" for m, won in wins.items())
    yield "`lp_uniform` below the quadric methods, which have the mesh", told, source


def paper() -> Iterator[tuple[str, str, str]]:
    """What became of the paper's statements."""
    source = "[paper](reports/paper/README.md)"
    program = [r for r in read("paper/program.csv") if r["density"] == "mean"]
    printed = [r for r in program if r["reading"] == "lp_printed"]
    farthest, clusters = (sum(column(printed, name)) for name in ("farthest_chosen", "clusters"))
    yield (
        "As printed (k = 1/PR), the program keeps the points farthest from the centroid",
        f"{farthest:.0f} of {clusters:.0f} clusters, two models, three rates",
        source,
    )
    density = [r for r in program if r["reading"] == "lp_density"]
    yield (
        "Read as k = 1, every cluster is proven optimal",
        f"{sum(column(density, 'proven')):.0f} of {sum(column(density, 'clusters')):.0f} clusters,"
        f" Z at most {max(column(density, 'largest_residual')):.0e} of the density",
        source,
    )
    counts = column(read("paper/counts.csv"), "n_output", model="stanford-bunny")
    yield (
        "The paper's 20,130 points at 70 %, all features kept",
        f"{min(counts):,.0f} to {max(counts):,.0f} over {len(counts)} fits",
        source,
    )
    errors = [r for r in read("paper/robustness.csv") if r["model"] == "stanford-bunny"]
    noisy = {
        m: sum(column(errors, "plane_error_k8_pct", method=m, kind="noise", level="1")) / 3
        for m in ("lp_printed", "lp_density", "lp_uniform", "random_sample")
    }
    yield (
        "Error against the clean bunny under noise of one mean spacing, 80 % removed",
        ", ".join(f"{m} {value:.3f} %" for m, value in noisy.items()),
        source,
    )


def speed() -> Iterator[tuple[str, str, str]]:
    """The filter against the one built from public parts."""
    benchmarks = json.loads((FOLDER / "benchmarks" / "filter.json").read_text(encoding="utf-8"))["benchmarks"]
    ratios = {b["name"]: b["extra_info"]["ratio"] for b in benchmarks}
    yield (
        "The paper's filter against scikit-learn, batched numpy and cold cvxpy + HiGHS, same run",
        f"whole {ratios['test_whole_filter_against_the_reference']:.0f}x,"
        f" clustering {ratios['test_clustering_against_scikit_learn']:.0f}x,"
        f" selection {ratios['test_selection_against_cold_highs']:.0f}x faster",
        "[benchmarks](reports/benchmarks/README.md)",
    )


def table() -> str:
    """The whole table in Markdown."""
    lines = ["| claim | measured | from |", "|---|---|---|"]
    claims = [*uniform(), *paper(), *speed()]
    return "\n".join([*lines, *(f"| {' | '.join(claim)} |" for claim in claims)]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(table())
