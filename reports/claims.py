"""The README's table of claims, from the committed files alone.

Run it from the root of the repository: ``python reports/claims.py``. A test holds the README against it.
"""

from __future__ import annotations

import csv
import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path

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


def _ratios(rows: list[Row], method: str, reference: str, metric: str) -> list[float]:
    """A method's metric over the reference's, for every model and reduction that both have."""
    found = {(r["method"], r["model"], r["reduction"]): float(r[metric]) for r in rows if r["status"] == "ok"}
    cases = [key[1:] for key in found if key[0] == method and (reference, *key[1:]) in found]
    return [found[method, *case] / found[reference, *case] for case in cases]


def _mean(values: list[float]) -> float:
    """Geometric mean."""
    return math.exp(sum(map(math.log, values)) / len(values))


def uniform() -> Iterator[tuple[str, str, str]]:
    """What `lp_uniform` and `lp_placed` reach."""
    rows = read("uniform/records.csv")
    source = "[uniform](reports/uniform/README.md)"
    for method, what in (("lp_uniform", "a subset of the raw points"), ("lp_placed", "its points moved")):
        ratios = _ratios(rows, method, "poisson_disk", "plane_error_pct")
        surface = _ratios(rows, method, "poisson_disk", "surface_distance_pct")
        yield (
            f"`{method}`, {what}: eq. 27 error as a multiple of Poisson disk sampling's at equal counts",
            f"{_mean(ratios):.2f} over {len(ratios)} cases, worst {max(ratios):.2f}; "
            f"triangulated surface {_mean(surface):.2f}",
            source,
        )
    wins = {m: _ratios(rows, "lp_uniform", m, "plane_error_pct") for m in MESH_RIVALS}
    told = "; ".join(f"{sum(r < 1 for r in ratios)} of {len(ratios)} ({m})" for m, ratios in wins.items())
    yield "`lp_uniform` below the quadric methods, which have the mesh", told, source


def paper() -> Iterator[tuple[str, str, str]]:
    """What became of the paper's statements."""
    source = "[paper](reports/paper/README.md)"
    programme = [r for r in read("paper/programme.csv") if r["density"] == "mean"]
    printed = [r for r in programme if r["reading"] == "lp_printed"]
    farthest, clusters = (sum(column(printed, name)) for name in ("farthest_chosen", "clusters"))
    yield (
        "As printed (k = 1/PR), the programme keeps the points farthest from the centroid",
        f"{farthest:.0f} of {clusters:.0f} clusters, two models, three rates",
        source,
    )
    density = [r for r in programme if r["reading"] == "lp_density"]
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
