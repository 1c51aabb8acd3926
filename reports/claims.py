"""The claims of the README, from the committed files alone: the number, how far it scatters, where it stands.

Run it from the root of the repository: ``python reports/claims.py``. A test holds the README against it.
"""

from __future__ import annotations

import csv
import json
import runpy
import sys
from collections.abc import Iterator
from math import exp, log
from pathlib import Path
from statistics import geometric_mean, mean, stdev
from typing import NamedTuple

from scipy.stats import binomtest, t

FOLDER = Path(__file__).resolve().parent
MESH_RIVALS = ("quadric_collapse", "quadric_decimation")
LEVEL = 0.95

Row = dict[str, str]


class Claim(NamedTuple):
    """What is said, the number, its interval, the page and the file of the number, and the command behind it."""

    what: str
    measured: str
    interval: str
    page: str
    file: str
    command: str


def read(name: str) -> list[Row]:
    """The rows of a committed CSV file."""
    with (FOLDER / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def column(rows: list[Row], name: str, **wanted: str) -> list[float]:
    """One column of the rows that match, as numbers."""
    return [float(r[name]) for r in rows if all(r[k] == v for k, v in wanted.items())]


def interval_over(groups: dict[str, list[float]], unit: str) -> str:
    """The 95 % interval of a geometric mean of ratios: Student's t on the logarithms, one value a group."""
    logs = [mean(map(log, ratios)) for ratios in groups.values()]
    half = t.ppf((1 + LEVEL) / 2, len(logs) - 1) * stdev(logs) / len(logs) ** 0.5
    low, high = (exp(mean(logs) + sign * half) for sign in (-1, 1))
    return f"{low:.2f} to {high:.2f} ({len(logs)} {unit})"


def interval_of_share(successes: float, trials: float) -> str:
    """The 95 % interval of a share, exact (Clopper and Pearson)."""
    found = binomtest(round(successes), round(trials)).proportion_ci(LEVEL)
    return f"{100 * found.low:.0f} to {100 * found.high:.0f} %"


def uniform() -> Iterator[Claim]:
    """What `lp_uniform` and `lp_placed` reach."""
    study = runpy.run_path(str(FOLDER / "uniform" / "ratios.py"))
    cases = study["read"](FOLDER / "uniform" / "records.csv")
    source = "uniform", "uniform/records.csv", "uniform"
    for method, what in (("lp_uniform", "a subset of the raw points"), ("lp_placed", "its points moved")):
        found = study["ratios"](cases, method)
        ratios, surface = (
            [r[k] for r in found.values()] for k in ("plane_error_pct", "surface_distance_pct")
        )
        clouds: dict[str, list[float]] = {}
        for (cloud, _), row in found.items():
            clouds.setdefault(cloud, []).append(row["plane_error_pct"])
        yield Claim(
            f"`{method}`, {what}: eq. 27 error as a multiple of Poisson disk sampling's at equal counts",
            f"{geometric_mean(ratios):.2f} over {len(ratios)} cases, worst {max(ratios):.2f}; "
            f"triangulated surface {geometric_mean(surface):.2f}",
            interval_over(clouds, "clouds"),
            *source,
        )
    rivals = {m: study["ratios"](cases, "lp_uniform", m).values() for m in MESH_RIVALS}
    wins = {m: [r["plane_error_pct"] < 1 for r in found] for m, found in rivals.items()}
    yield Claim(
        "`lp_uniform` below the quadric methods, which have the mesh",
        "; ".join(f"{sum(won)} of {len(won)} ({m})" for m, won in wins.items()),
        "; ".join(interval_of_share(sum(won), len(won)) for won in wins.values()),
        *source,
    )


def paper() -> Iterator[Claim]:
    """What became of the paper's statements."""
    program = [r for r in read("paper/program.csv") if r["density"] == "mean"]
    source = "paper", "paper/program.csv", "paper"
    printed = [r for r in program if r["reading"] == "lp_printed"]
    farthest, clusters = (sum(column(printed, name)) for name in ("farthest_chosen", "clusters"))
    yield Claim(
        "As printed (k = 1/PR), the program keeps the points farthest from the centroid",
        f"{farthest:.0f} of {clusters:.0f} clusters, two models, three rates",
        interval_of_share(farthest, clusters),
        *source,
    )
    density = [r for r in program if r["reading"] == "lp_density"]
    proven, clusters = (sum(column(density, name)) for name in ("proven", "clusters"))
    yield Claim(
        "Read as k = 1, every cluster is proven optimal",
        f"{proven:.0f} of {clusters:.0f} clusters,"
        f" Z at most {max(column(density, 'largest_residual')):.0e} of the density",
        interval_of_share(proven, clusters),
        *source,
    )
    counts = column(read("paper/counts.csv"), "n_output", model="stanford-bunny")
    yield Claim(
        "The paper's 20,130 points at 70 %, all features kept",
        f"{min(counts):,.0f} to {max(counts):,.0f} over {len(counts)} fits",
        "all fits",
        *("paper", "paper/counts.csv", "paper"),
    )
    errors = [r for r in read("paper/robustness.csv") if r["model"] == "stanford-bunny"]
    noisy = {
        m: column(errors, "plane_error_k8_pct", method=m, kind="noise", level="1")
        for m in ("lp_printed", "lp_density", "lp_uniform", "random_sample")
    }
    n_seeds = min(map(len, noisy.values()))
    yield Claim(
        "Error against the clean bunny under noise of one mean spacing, 80 % removed",
        ", ".join(f"{m} {mean(values):.3f} %" for m, values in noisy.items()),
        ", ".join(f"{min(values):.3f} to {max(values):.3f}" for values in noisy.values())
        + f" (all {n_seeds} seeds)",
        *("paper", "paper/robustness.csv", "paper"),
    )


def speed() -> Iterator[Claim]:
    """The filter against the one built from public parts."""
    benchmarks = json.loads((FOLDER / "benchmarks" / "filter.json").read_text(encoding="utf-8"))["benchmarks"]
    facts = {b["name"]: b["extra_info"] for b in benchmarks}
    names = {
        "whole": "test_whole_filter_against_the_reference",
        "clustering": "test_clustering_against_scikit_learn",
        "selection": "test_selection_against_cold_highs",
    }
    yield Claim(
        "The paper's filter against scikit-learn, batched numpy and cold cvxpy + HiGHS, same run",
        ", ".join(f"{what} {facts[name]['ratio']:.0f}x" for what, name in names.items()) + " faster",
        ", ".join(_ratio_span(facts[name]) for name in names.values()) + " (all repeats)",
        *("benchmarks", "benchmarks/filter.json", "benchmarks"),
    )


def _ratio_span(facts: dict[str, list[float]]) -> str:
    """The least and the largest ratio that repeats of the two sides give."""
    ours, theirs = facts["ours_s"], facts["reference_s"]
    return f"{min(theirs) / max(ours):.0f} to {max(theirs) / min(ours):.0f}x"


def claims() -> list[Claim]:
    """Every claim of the README."""
    return [*uniform(), *paper(), *speed()]


def table() -> str:
    """The README's table in Markdown."""
    rows = [f"| {c.what} | {c.measured} | [{c.page}](reports/{c.page}/README.md) |" for c in claims()]
    return "\n".join(["| claim | measured | from |", "|---|---|---|", *rows]) + "\n"


def index() -> str:
    """The table of reports/README.md in Markdown: with the interval, the file and the command of each number."""
    rows = [
        f"| {c.what} | {c.measured} | {c.interval} | [{c.file}]({c.file})"
        f" | `python reports/make.py --models FOLDER --only {c.command}` |"
        for c in claims()
    ]
    heads = ["| claim | measured | 95 % interval or range | file | command |", "|---|---|---|---|---|"]
    return "\n".join([*heads, *rows]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(table())
