"""The tables of reports/uniform/README.md: metrics over those of Poisson disk sampling, from records.csv.

``python docs/make.py`` puts them there.
"""

from __future__ import annotations

import csv
import json
import math
from collections import defaultdict
from pathlib import Path
from statistics import geometric_mean

REFERENCE = "poisson_disk"
COLUMNS = {
    "plane_error_pct": "eq. 27, k = 8",
    "plane_error_k6_pct": "k = 6",
    "plane_error_k12_pct": "k = 12",
    "surface_distance_pct": "surface",
    "hausdorff_pct": "Hausdorff",
    "mean_distance_pct": "coverage",
    "normal_deviation_deg": "normals",
    "mls_distance_pct": "MLS",
}


def read(path: Path) -> dict[tuple[str, str], dict[str, dict[str, float]]]:
    """Metrics by (model, reduction), then by method; cases that are not ok are left out."""
    cases: dict[tuple[str, str], dict[str, dict[str, float]]] = defaultdict(dict)
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["status"] == "ok":
                values = {name: float(row[name]) for name in COLUMNS}
                values["residual"] = json.loads(row["info"] or "{}").get("largest_residual", math.nan)
                cases[row["model"], row["reduction"]][row["method"]] = values
    return cases


def ratios(cases: dict, method: str, reference: str = REFERENCE) -> dict[tuple[str, str], dict[str, float]]:
    """Each metric of ``method`` over that of the reference, case by case."""
    return {
        case: {name: rows[method][name] / rows[reference][name] for name in COLUMNS}
        for case, rows in cases.items()
        if method in rows and reference in rows
    }


def summary(cases: dict) -> list[str]:
    """One line per method: geometric mean, and the worst case in brackets."""
    methods = sorted({method for rows in cases.values() for method in rows} - {REFERENCE})
    lines = [_line("method", "cases", *COLUMNS.values()), _line(*["---"] * (len(COLUMNS) + 2))]
    for method in methods:
        found = list(ratios(cases, method).values())
        cells = [mean_and_worst([row[name] for row in found]) for name in COLUMNS]
        lines.append(_line(method, str(len(found)), *cells))
    return lines


def by_reduction(cases: dict, method: str) -> list[str]:
    """One line per reduction of ``method``: geometric mean, and the worst case in brackets."""
    lines = [_line("removed", "cases", *COLUMNS.values()), _line(*["---"] * (len(COLUMNS) + 2))]
    for reduction in sorted({reduction for _, reduction in cases}, key=float):
        some = {case: rows for case, rows in cases.items() if case[1] == reduction}
        found = list(ratios(some, method).values())
        cells = [mean_and_worst([row[name] for row in found]) for name in COLUMNS]
        lines.append(_line(f"{100 * float(reduction):.0f} %", str(len(found)), *cells))
    return lines


def against_meshes(cases: dict, method: str) -> list[str]:
    """One line per method that has the mesh: in how many cases ``method`` is below it, by each measure."""
    lines = [_line("against", "cases", *COLUMNS.values()), _line(*["---"] * (len(COLUMNS) + 2))]
    for rival in ("quadric_collapse", "quadric_decimation"):
        found = list(ratios(cases, method, rival).values())
        won = [
            f"{sum(row[name] < 1 for row in found)} ({geometric_mean([row[name] for row in found]):.2f})"
            for name in COLUMNS
        ]
        lines.append(_line(rival, str(len(found)), *won))
    return lines


def by_case(cases: dict, method: str) -> list[str]:
    """One line per case of ``method``, beside the rivals that have the mesh, and the worst cluster's Z."""
    rivals = ("quadric_collapse", "quadric_decimation")
    lines = [_line("case", *COLUMNS.values(), *(f"eq. 27 over {r}" for r in rivals), "largest Z / D")]
    lines.append(_line(*["---"] * (len(COLUMNS) + 4)))
    for case, row in ratios(cases, method).items():
        own = cases[case][method]["plane_error_pct"]
        over = [
            f"{own / cases[case][r]['plane_error_pct']:.2f}" if r in cases[case] else "no mesh"
            for r in rivals
        ]
        residual = f"{100 * cases[case][method]['residual']:.2f} %"
        lines.append(_line(" ".join(case), *(f"{row[name]:.2f}" for name in COLUMNS), *over, residual))
    return lines


def mean_and_worst(values: list[float]) -> str:
    """Geometric mean, and the largest in brackets."""
    return f"{geometric_mean(values):.2f} ({max(values):.2f})"


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"
