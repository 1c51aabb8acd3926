"""The page of the reproduction, written from the measured tables alone."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from reports.paper.audit import Tables, audit
from reports.paper.published import counterpart, published
from reports.paper.rows import Rows, distinct, span, values, where

STAGES = {"normals": "normals, curvature", "clustering": "clustering", "selection": "simplification"}


def render(tables: Tables, made: dict[str, Any]) -> str:
    """The whole page.

    Parameters
    ----------
    tables : mapping of str to rows
        The measured tables by file stem.
    made : dict
        How the tables were made: ``command``, ``commit``, ``machine``, ``versions``, ``date``, ``left_out``.

    Returns
    -------
    str
        Markdown, the same for the same tables.
    """
    lines = [*_head(made)]
    for model in distinct(tables["seconds"], "model"):
        lines += _model_part(tables, model)
    lines += _foot(tables, made)
    return "\n".join(lines) + "\n"


def read_made(folder: Path) -> dict[str, Any]:
    """How the tables of a folder were made."""
    return json.loads((folder / "made.json").read_text(encoding="utf-8"))


def _head(made: dict[str, Any]) -> Iterator[str]:
    yield "# Leal, Leal and Sanchez-Torres (2017), measured again"
    yield ""
    yield "*A Linear Programming Approach for 3D Point Cloud Simplification*, IAENG International Journal of"
    yield "Computer Science 44:1. Every number and picture here comes from the CSV files beside it, made by"
    yield ""
    yield f"    {made['command']}"
    yield ""
    yield f"on {made['date']}, commit {made['commit']}, {made['machine']}; {made['versions']}."
    yield f"The paper's times are another machine's ({published()['machine']}): the ratios hold for these two"
    yield "machines and programs, not for the algorithms."
    yield from (f"\n**Left out:** {reason}" for reason in made["left_out"])
    yield ""


def _model_part(tables: Tables, model: str) -> Iterator[str]:
    paper = counterpart(model)
    n_points = int(where(tables["counts"], model=model)[0]["n_points"])
    yield f"## {model}"
    yield ""
    yield f"{n_points:,} points{_size_note(paper, n_points)}."
    yield ""
    yield from _audit_part(tables, model)
    yield from _table_one(where(tables["seconds"], model=model), paper)
    for file, caption in pictures(model):
        yield f"![{caption}]({file})"
        yield ""
        yield f"*{caption}*"
        yield ""


def _size_note(paper: dict[str, Any] | None, n_points: int) -> str:
    if paper is None:
        return "; not one of the paper's models"
    if paper["points"] == n_points:
        return ", as in the paper"
    there = f"the paper's copy of {paper['title']} has {paper['points']:,}"
    return f"; {there}, so this is another mesh of the same shape"


def pictures(model: str) -> list[tuple[str, str]]:
    """File names and captions of a model's pictures, in the paper's order."""
    return [
        (f"{model}-fig4-clusters.png", "Fig. 4: the clusters, K = 20."),
        (f"{model}-fig5-curvature.png", "Fig. 5: absolute curvature (eq. 11) and the feature points."),
        (
            f"{model}-fig6-reduced.png",
            "Figs. 6 and 7: original, and 70, 80 and 90 % removed by the printed program with all features"
            " kept (K = 20); triangulated by ball pivoting, shaded and wireframe.",
        ),
        (
            f"{model}-holes.png",
            "At 90 %, equal counts: the printed program, the density reading, lp_uniform.",
        ),
        (f"{model}-fig8-seconds.png", "Fig. 8: seconds per stage against the number of clusters."),
        (
            f"{model}-fig9-errors.png",
            "Fig. 9: eq. 27 error (8 neighbours) against the number of clusters; the bands span the seeds.",
        ),
    ]


def _audit_part(tables: Tables, model: str) -> Iterator[str]:
    yield "### The paper's statements"
    yield ""
    for finding in audit(tables, model):
        verdict, file = finding.verdict.capitalize(), finding.file
        yield f"- *{finding.statement}* **{verdict}.** {finding.evidence} ([{file}]({file}))"
    yield ""


def _table_one(rows: Rows, paper: dict[str, Any] | None) -> Iterator[str]:
    """Table I: median seconds of each cell, the paper's, and how many times faster."""
    clusters = distinct(rows, "n_clusters")
    yield "### Table I: seconds per stage"
    yield ""
    yield "Median of the repeats; in brackets the paper's seconds, and how many times ours go into them."
    yield "([seconds.csv](seconds.csv))"
    yield ""
    yield "| removed | stage | " + " | ".join(f"K = {k}" for k in clusters) + " |"
    yield "|---|---|" + "---|" * len(clusters)
    totals: list[float] = []
    for rate in sorted(distinct(rows, "reduction"), reverse=True):
        for stage, title in STAGES.items():
            ours = [_median(rows, f"{stage}_s", k, rate) for k in clusters]
            theirs = paper["seconds"][rate][stage] if paper else [None] * len(clusters)
            yield _cells(f"{float(rate):.0%}", title, ours, theirs)
        ours = [sum(_median(rows, f"{s}_s", k, rate) for s in STAGES) for k in clusters]
        theirs = _totals(paper["seconds"][rate]) if paper else [None] * len(ours)
        yield _cells(f"{float(rate):.0%}", "**all**", ours, theirs)
        totals += [t / o for t, o in zip(theirs, ours, strict=True) if t is not None]
    yield ""
    if totals:
        yield f"All stages together take {span(totals, '.0f')} times less than the paper's (machines differ)."
        yield ""


def _totals(stages: dict[str, list[float]]) -> list[float]:
    return [sum(cell) for cell in zip(*stages.values(), strict=True)]


def _median(rows: Rows, column: str, n_clusters: str, reduction: str) -> float:
    cell = sorted(values(rows, column, n_clusters=n_clusters, reduction=reduction))
    return float(cell[len(cell) // 2])


def _cells(rate: str, title: str, ours: Sequence[float], theirs: Sequence[float | None]) -> str:
    pairs = zip(ours, theirs, strict=True)
    cells = [f"{o:.3f}" if t is None else f"{o:.3f} ({t:.1f}, {t / o:.0f}x)" for o, t in pairs]
    return f"| {rate} | {title} | " + " | ".join(cells) + " |"


def _foot(tables: Tables, made: dict[str, Any]) -> Iterator[str]:
    yield "## Files"
    yield ""
    for name, rows in tables.items():
        yield f"- [{name}.csv]({name}.csv): {made['titles'][name]}; {len(rows)} rows."
