"""The tables of docs/large.md, from the files of this folder."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

from lpcompare.report.tables import markdown_table

HERE = Path(__file__).resolve().parent
RATIOS = {
    "plane_error_pct": "plane error (eq. 27)",
    "surface_distance_pct": "distance to the triangulated surface",
    "hausdorff_pct": "Hausdorff distance",
    "normal_deviation_deg": "normal deviation",
    "near_over_far": "kept points within one halo of a seam over those farther away, each over those in memory",
    "strip_1": "kept points within one disk radius of a seam, over those in memory",
    "strip_2": "kept points of the next strip of that width, over those in memory",
}
STAGES = {
    "reading": ("reading", "input once"),
    "spilling": ("spilling, sorting", "input once, 96"),
    "curvature": ("curvature", "24 and the halo, 42"),
    "budgets": ("sums, weights, budgets", "about 60 in each of five passes"),
    "cells": ("cells", "66 and the halo"),
    "swaps": ("swaps", "66 and the halo"),
    "selection": ("selection", "66 and the halo"),
    "writing": ("writing, in the first process alone", "input once"),
}
TOGETHER = {"sorting": "spilling", "densities": "budgets", "weights": "budgets", "tilts": "budgets"}


def read(name: str) -> list[dict[str, str]]:
    """The rows of a file of this folder."""
    with (HERE / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def seams() -> Iterator[str]:
    """Tiles over the whole in memory, for every size that was measured."""
    found = {
        (int(row["points"]), int(row["tiles"])): row
        for file in sorted(HERE.glob("seams-*.csv"))
        for row in read(file.name)
    }
    tiled = sorted(key for key in found if key[1])
    heads = [f"{points:,} points, {tiles} tiles" for points, tiles in tiled]
    rows = [
        [title, *(f"{float(found[key][column]):.3f}" for key in tiled)] for column, title in RATIOS.items()
    ]
    largest = [f"{float(found[key]['largest_residual']):.3f}" for key in tiled]
    rows.append(["largest Z of eq. 14 over the clusters; 0.05 is allowed", *largest])
    in_memory = [f"{float(found[points, 0]['largest_residual']):.3f}" for points, _ in tiled]
    rows.append(["the same in memory", *in_memory])
    yield from markdown_table(["", *heads], rows)


def stages() -> Iterator[str]:
    """Microseconds of each stage."""
    sums = dict.fromkeys(STAGES, 0.0)
    for row in read("tasks.csv"):
        sums[TOGETHER.get(row["stage"], row["stage"])] += float(row["microseconds"])
    rows = [[title, f"{sums[stage]:.1f}", moved] for stage, (title, moved) in STAGES.items()]
    yield from markdown_table(["stage", "microseconds", "bytes read and written"], rows, "---")


def hours() -> Iterator[str]:
    """Simulated hours by points and workers."""
    rows = read("scaling.csv")
    workers = sorted({int(row["workers"]) for row in rows})
    known = {(int(row["points"]), int(row["workers"])): float(row["hours"]) for row in rows}
    table = [
        [f"{points:,}", *(f"{float(f'{known[points, n]:.2g}'):,g}" for n in workers)]
        for points in sorted({points for points, _ in known})
    ]
    heads = ["points", *(f"{n:,} worker{'s' if n > 1 else ''}" for n in workers)]
    yield from markdown_table(heads, table)


def rivals() -> Iterator[str]:
    """Programs that thin the survey."""
    rows = [
        [
            row["program"],
            f"{int(row['kept']):,}",
            f"{float(row['seconds']):.0f}",
            f"{float(row['cpu_s']):.0f}",
            f"{float(row['peak_mib']):,.0f}",
            f"{float(row['plane_error']):.3f}",
        ]
        for row in sorted(read("rivals.csv"), key=lambda row: float(row["plane_error"]))
    ]
    heads = ["program", "kept", "wall s", "CPU s", "peak memory, MiB", "plane error, m"]
    yield from markdown_table(heads, rows, "---")
