"""What each method of the study is good at, in sentences and tables that are made from records.csv.

``python docs/make.py`` puts them into docs/strengths.md.

A method's place by a measure: on each cloud and reduction, the methods that returned the count are ranked; the
rank counts as a share of those ranked, so that a case with fewer methods weighs as much; the mean of these
shares over the cases orders the methods. The place over all measures orders the means over the measures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from lpcompare.benchmark.record import Run, load_run
from lpcompare.registry import METHODS
from lpcompare.report.cells import RUNTIME, cells, columns, mean_ratios, witnesses
from lpcompare.report.tables import count, escape_markdown, listing, markdown_table, percent, seconds

REFERENCE = "poisson_disk"
MISS = 0.01
"""A count is missed when it differs from the one asked for by more than this share."""

FEWEST = 1 / 3
"""A method has places when it returned the count in at least this share of the cases."""

DEFAULT, LOST = "lp_uniform", 10
"""The method of which it is said first by which measures it is behind this place."""

QUICK_ON, QUICK_S, SLOWEST = ("stanford-bunny", 0.9), 10, 8
"""Where a call may take no more than this many seconds, and how many of the slowest are named."""

ENDS = 1 / 6
"""The first and the last share of the places: what a method is good at, and what it is poor at."""

FAMILIES = {
    "ours": "Boolean programs (ours)",
    "spacing": "Even distances",
    "voxel": "Cells of a grid",
    "random": "Chance",
    "clustering": "Clusters",
    "surface": "Error of a surface",
    "curvature": "Curvature and features",
    "graph": "Graphs",
    "mesh": "Collapse of a mesh",
    "": "Others",
}
MEASURES = {
    "plane_error_pct": "plane error",
    "plane_error_k6_pct": "plane error of 6 neighbors",
    "plane_error_k12_pct": "plane error of 12 neighbors",
    "plane_error_max_pct": "largest plane error",
    "surface_distance_pct": "surface distance",
    "surface_distance_p95_pct": "the 95 % surface distance",
    "surface_distance_max_pct": "largest surface distance",
    "mls_distance_pct": "MLS distance",
    "mls_distance_max_pct": "largest MLS distance",
    "normal_deviation_deg": "angle of normals",
    "mean_distance_pct": "mean distance",
    "d1_mse": "D1",
    "d2_mse": "D2",
    "hausdorff_pct": "Hausdorff distance",
    "density_objective_pct": "density",
    "density_objective_max_pct": "density of the worst cluster",
    "spacing_variation": "evenness",
}
MOST_NAMED = 4
"""Measures that are named where a method is first; of more, the number is said."""

GOALS = {
    "plane_error_pct": "keeping the shape",
    "surface_distance_pct": "keeping the surface",
    "normal_deviation_deg": "keeping directions",
    "mean_distance_pct": "covering the cloud",
    "hausdorff_pct": "avoiding holes",
    "density_objective_pct": "keeping the density",
    "spacing_variation": "spacing evenly",
}
ENDED = {"skipped": "did not apply", "timeout": "ran out of time"}


class Study:
    """The cells of a run, and the places of its methods.

    Attributes
    ----------
    table, fair : DataFrame
        All cells; those with a result of the count that was asked for.
    shares : DataFrame
        Mean rank by method and measure, from 0 (always first) to 1 (always last).
    places : DataFrame
        1 for the best mean rank; the last column, ``all``, is the place over all measures.
    """

    def __init__(self, run: Run) -> None:
        self.run, self.table = run, cells(run.frame)
        got = self.table[self.table.n_ok > 0]
        self.fair = got[(got.n_output / got.target_count - 1).abs() <= MISS]
        found = witnesses(columns(self.table))
        self.keys = [key for key in MEASURES if key in found]
        self.n_cases = self.table.groupby(["input", "reduction"]).ngroups
        self.shares = self._shares()
        ordered = self.shares.assign(all=self.shares.mean(axis=1))
        self.places = ordered.rank(method="min").astype(int).sort_values("all", kind="stable")

    def _shares(self) -> pd.DataFrame:
        groups = self.fair.groupby(["input", "reduction"], sort=False)[self.keys]
        ranked = (groups.rank() - 1) / (groups.transform("count") - 1)
        means = ranked.groupby(self.fair.label).mean()
        return means[self.fair.label.value_counts().reindex(means.index) >= FEWEST * self.n_cases]


def study(folder: Path) -> Study:
    """The study of a committed run."""
    return Study(load_run(folder))


def paragraphs(found: Study) -> Iterator[str]:
    """One paragraph for each method, by family, the best place first."""
    ratios = mean_ratios(found.fair, REFERENCE, [k for k in GOALS if k in found.keys])[0]
    labels = list(found.table.label.unique())
    for family, title in FAMILIES.items():
        of_family = [m for m in labels if METHODS.traits(m).family == family]
        if of_family:
            yield from (f"### {title}", "")
        for method in sorted(of_family, key=lambda m: found.places["all"].get(m, math.inf)):
            yield from (" ".join(_sentences(found, method, ratios)), "")


def winners(found: Study) -> Iterator[str]:
    """Who has the first places by each measure, and the place of our default; what it loses comes first."""
    places, ours = found.places, found.places.loc[DEFAULT]
    lost = [f"{MEASURES[key]} ({ours[key]})" for key in found.keys if ours[key] > LOST]
    yield f"`{DEFAULT}`, the default, is not among the first {LOST} by {listing(lost)}." if lost else ""
    yield ""
    subsets = [m for m in places.index if not METHODS.traits(m).moves_points]
    rows = []
    for key in [*found.keys, "all"]:
        ordered = places[key].sort_values(kind="stable").index
        best = next(m for m in ordered if m in subsets)
        title = MEASURES.get(key, "all of them")
        rows.append([title, *(f"`{m}`" for m in (*ordered[:2], best)), str(ours[key])])
    heads = ["measure", "first", "second", "first that keeps points", "default's place"]
    yield from markdown_table(heads, rows, "---")
    yield ""
    yield f"{len(places)} of {found.table.label.nunique()} methods have a place."


def failures(found: Study) -> Iterator[str]:
    """The cases without a result, by method."""
    bad = found.table[found.table.n_ok.eq(0)]
    groups = bad.groupby(["label", "status", "message"], sort=False)
    rows = [
        [f"`{m}`", ENDED.get(status, status), str(len(part)), _where(part), escape_markdown(message)]
        for (m, status, message), part in groups
    ]
    if not rows:
        yield "Every case has a result."
        return
    yield from markdown_table(["method", "end", "cases", "on", "message"], rows, "---")


def speed(found: Study) -> Iterator[str]:
    """Calls that are too slow on the cloud of the promise, the slowest of them, and the most memory."""
    cloud, reduction = QUICK_ON
    frame = found.run.frame[found.run.frame.status.eq("ok")]
    here = frame[frame.model.eq(cloud) & frame.reduction.eq(reduction)]
    here = here.groupby("method")[["n_input", RUNTIME, "cpu_s", "calibration_s", "foreign_load"]].median()
    yield f"On {cloud} ({here.n_input.max():,.0f} points, {percent(reduction)} removed), a call may take {QUICK_S} s."
    yield f"By processor time, {_longer(here.cpu_s)}; by the clock, {_longer(here[RUNTIME])}."
    yield f"Other work took {here.foreign_load.median():.1f} processors meanwhile. The {SLOWEST} slowest calls:"
    yield ""
    last = here.sort_values("cpu_s", ascending=False, kind="stable").head(SLOWEST)
    rows = [
        [f"`{m}`", *(seconds(v).replace("n/a", "") for v in last.loc[m][["cpu_s", RUNTIME]])]
        for m in last.index
    ]
    yield from markdown_table(["method", "processor time", "by the clock"], rows, "---")
    yield ""
    largest = found.table[found.table.n_input.eq(found.table.n_input.max())]
    peak = largest.loc[largest.peak_memory_mib.idxmax()]
    yield f"The most memory on the largest cloud ({peak.input}, {peak.n_input:,.0f} points), libraries included:"
    yield f"{peak.peak_memory_mib:,.0f} MiB (`{peak.label}`)."


def _longer(times: pd.Series) -> str:
    slow = [f"`{m}`" for m in times.index[times > QUICK_S]]
    return f"{count(len(slow), 'method')} took longer ({listing(slow)})" if slow else "no method took longer"


def _sentences(found: Study, method: str, ratios: pd.DataFrame) -> Iterator[str]:
    """The paragraph of a method, sentence by sentence."""
    yield f"**`{method}`**: {METHODS.summary(method)}"
    if method in found.places.index:
        yield from _goals(found, method)
        yield from _ranks(found, method)
        yield from _ratios(method, ratios)
    else:
        yield "It has no place: it returned the count that was asked for in too few cases."
    yield from _time(found, method)
    yield from _endings(found, method)


def _goals(found: Study, method: str) -> Iterator[str]:
    places, n = found.places.loc[method], len(found.places)
    good = [goal for key, goal in GOALS.items() if key in places and places[key] <= ENDS * n]
    poor = [goal for key, goal in GOALS.items() if key in places and places[key] > (1 - ENDS) * n]
    parts = [f"{word} {listing(goals)}" for word, goals in (("good at", good), ("poor at", poor)) if goals]
    if parts:
        text = "; ".join(parts)
        yield f"{text[0].upper()}{text[1:]}."


def _ranks(found: Study, method: str) -> Iterator[str]:
    places, n = found.places.loc[method], len(found.places)
    by = places[found.keys]
    first = [MEASURES[key] for key in found.keys if by[key] == 1]
    yield f"Over all {len(by)} measures it has place {places['all']} of {n}."
    if first:
        yield f"It is first by {listing(first) if len(first) <= MOST_NAMED else f'{len(first)} of them'}."
    worst = f"worst by {MEASURES[by.idxmax()]} (place {by.max()})"
    yield (
        f"It is {worst}." if first else f"It is best by {MEASURES[by.idxmin()]} (place {by.min()}), {worst}."
    )


def _ratios(method: str, ratios: pd.DataFrame) -> Iterator[str]:
    if method != REFERENCE and method in ratios.index:
        error, holes = (f"{ratios.at[method, key]:.2f}" for key in ("plane_error_pct", "hausdorff_pct"))
        yield f"Its plane error is {error} and its Hausdorff distance {holes} times that of `{REFERENCE}`."


def _time(found: Study, method: str) -> Iterator[str]:
    mine = found.table[found.table.label.eq(method)]
    times, search = mine[RUNTIME].dropna(), mine.calibration_s.median()
    if len(times):
        before = f", after a search of {seconds(search)} for its setting" if search > 0 else ""
        span = f"{seconds(times.median())} in the median ({seconds(times.min())} to {seconds(times.max())})"
        yield f"A call takes {span}{before}."


def _endings(found: Study, method: str) -> Iterator[str]:
    mine = found.table[found.table.label.eq(method)]
    ends = mine[mine.n_ok.eq(0)].status.value_counts(sort=False)
    told = [f"{n} {ENDED.get(str(status), status)}" for status, n in ends.items()]
    off = int(mine.n_ok.gt(0).sum()) - int(found.fair.label.eq(method).sum())
    told += [f"{off} gave another count than the one asked for"] if off else []
    cases = f"{len(mine)} cases"
    yield (
        f"Of its {cases}, {listing(told)}." if told else f"All its {cases} gave the count that was asked for."
    )


def _where(part: pd.DataFrame) -> str:
    return escape_markdown(listing(list(part.input.unique())))
