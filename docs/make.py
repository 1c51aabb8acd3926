"""The parts of the pages that come from code and from the files under reports/.

A page marks such a part with ``<!-- made by docs/make.py: NAME -->`` before it and ``<!-- end -->`` after it.
``python docs/make.py`` writes all of them again, ``docs/methods.md`` too; a test holds the pages against them.
"""

from __future__ import annotations

import json
import math
import re
import runpy
import sys
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from statistics import geometric_mean
from typing import Any

import typer
from typer.testing import CliRunner

import lpcompare
from lpcompare.benchmark.record import load_run
from lpcompare.cli import build_app
from lpcompare.models.catalogue import catalogue
from lpcompare.registry import METHODS, METRICS
from lpcompare.report.cells import cells, mean_ratios
from lpcompare.report.tables import format_run, listing, markdown_table

DOCS = Path(__file__).resolve().parent
REPORTS = DOCS.parent / "reports"
PART = re.compile(r"(<!-- made by docs/make\.py: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)

REFERENCE = "poisson_disk"
GOALS = {
    "plane_error_pct": "the shape: little distance of the originals to planes through kept points (eq. 27)",
    "surface_distance_pct": "a surface: little distance of the originals to triangles of kept points",
    "normal_deviation_deg": "directions: the normals of the kept points are those of the original",
    "mean_distance_pct": "cover: every original has a kept point near it, on average",
    "hausdorff_pct": "no holes: no original is far from a kept point",
    "density_objective_pct": "density: thick places stay thick, thin places thin (eq. 14)",
    "spacing_variation": "evenness: all kept points are equally far apart",
}
KINDS = {"your own points": (False, False), "new points": (True, False), "the mesh is known": (None, True)}
TIMED = (
    "random_sample",
    "voxel_nearest",
    "poisson_disk",
    "farthest_point",
    "lp_density",
    "lp_uniform",
    "lp_placed",
)
CLOUDS = {
    "stanford-bunny": "laser scan of an object",
    "igea-face": "part of a dense laser scan of an object",
    "max-planck": "laser scan of an object",
    "nefertiti": "reduced scan",
    "beast": "modelled creature",
    "ogre": "modelled creature, 44 pieces",
    "fandisk": "CAD part with sharp edges",
    "bunny-one-scan": "one raw range scan",
    "range-map-lato315": "one raw range map",
    "bunny-ten-scans-part": "ten aligned scans with their noise",
    "depth-tabletop-part": "depth camera, a table",
    "depth-rgb-part": "depth camera, a room",
    "lidar-room-part": "indoor laser scan",
    "street-simulated": "simulated scan from a car",
    "airborne-autzen": "airborne laser scan, town",
    "airborne-terrain-part": "airborne laser scan, terrain with vegetation",
    "terrain-csite2-sample": "airborne laser scan, terrain",
    "forest-part": "laser scan of a forest",
}


def choice() -> Iterator[str]:
    """What to use for which goal, from reports/methods: the best method of each kind."""
    run = load_run(REPORTS / "methods")
    table = cells(run.frame)
    plain = [m for m in METHODS if not (METHODS.traits(m).extra or METHODS.traits(m).install)]
    table = table[table.method.isin(plain)]
    goals = {key: goal for key, goal in GOALS.items() if key in table}
    means, _ = mean_ratios(table, REFERENCE, list(goals))
    rows = [[goal, *(_best(means[key], *kind) for kind in KINDS.values())] for key, goal in goals.items()]
    yield from markdown_table(["what must survive", *KINDS], rows, "---")
    cases = table.groupby(["input", "reduction"]).ngroups
    yield ""
    yield f"In brackets: the measure as a multiple of `{REFERENCE}`'s, geometric mean over {cases} cases"
    yield f"({table.input.nunique()} clouds, {_percents(table.reduction)} removed); below 1 is better. Only methods of"
    yield f"a plain installation take part. From [reports/methods](../reports/methods/README.md), made {_day(run)}."


def _uniform() -> tuple[dict[str, Any], dict[Any, Any]]:
    """The functions of reports/uniform/ratios.py, and the cases of the study."""
    study = runpy.run_path(str(REPORTS / "uniform" / "ratios.py"))
    return study, study["read"](REPORTS / "uniform" / "records.csv")


def inputs() -> Iterator[str]:
    """How the two methods of ours do on each kind of cloud, from reports/uniform."""
    study, cases = _uniform()
    keys = ("plane_error_pct", "surface_distance_pct", "hausdorff_pct")
    found = {m: study["ratios"](cases, m) for m in ("lp_uniform", "lp_placed")}
    rows = []
    for cloud in dict.fromkeys(name for name, _ in found["lp_uniform"]):
        rows.append([cloud, CLOUDS.get(cloud, "")])
        for ratios in found.values():
            values = [[row[key] for (name, _), row in ratios.items() if name == cloud] for key in keys]
            rows[-1] += [f"{geometric_mean(v):.2f}" for v in values]
    titles = ("plane error", "surface", "Hausdorff")
    heads = [f"`{method}`: {title}" for method in found for title in titles]
    yield from markdown_table(["cloud", "kind", *heads], sorted(rows, key=_place), "---")
    yield ""
    removed = _percents({float(reduction) for _, reduction in cases})
    yield f"Multiples of `{REFERENCE}`'s, geometric mean over {removed} removed; below 1 is better."
    yield "From [reports/uniform](../reports/uniform/README.md), which says when and with what it was made."


def reach() -> Iterator[str]:
    """What our two methods reach, from reports/uniform."""
    study, cases = _uniform()
    yield from ("All cases:", "", *study["summary"](cases))
    for method in ("lp_uniform", "lp_placed"):
        yield from ("", f"`{method}` by reduction:", "", *study["by_reduction"](cases, method))
    yield from (
        "",
        "`lp_uniform` against methods that have the mesh: the number of cases where it is below, and in",
    )
    yield from (
        "brackets the geometric mean of the ratio.",
        "",
        *study["against_meshes"](cases, "lp_uniform"),
    )


def settings() -> Iterator[str]:
    """What the settings of `lp_uniform` change, from the sweep of reports/uniform."""
    study = _uniform()[0]
    cases = study["read"](REPORTS / "uniform" / "sweep.csv")
    clouds, reductions = (sorted({case[i] for case in cases}) for i in (0, 1))
    yield f"{len(clouds)} small clouds ({', '.join(clouds)}), {_percents(map(float, reductions))} removed:"
    yield ""
    yield from study["summary"](cases)


def uniform() -> Iterator[str]:
    """All tables of reports/uniform."""
    study, cases = _uniform()
    yield from reach()
    for method in ("lp_uniform", "lp_placed"):
        yield from ("", f"## `{method}`, case by case", "", *study["by_case"](cases, method))


def damaged() -> Iterator[str]:
    """`lp_uniform` over Poisson disk sampling on damaged inputs, from reports/robustness."""
    study, frame = _uniform()[0], load_run(REPORTS / "robustness").frame
    measures, by = study["COLUMNS"], ["perturbation", "perturbation_level", "model"]
    ours, theirs = (
        frame[frame.method.eq(method)].set_index(by)[list(measures)] for method in ("lp_uniform", REFERENCE)
    )
    rows = [
        [
            kind if kind == "none" else f"{kind} {level:g}",
            *(study["mean_and_worst"](list(part[key])) for key in measures),
        ]
        for (kind, level), part in (ours / theirs).groupby(by[:2])
    ]
    yield from markdown_table(["damage", *measures.values()], rows, "---")


@cache
def _strengths() -> tuple[dict[str, Any], Any]:
    """The functions of reports/methods/strengths.py, and the study of every method."""
    functions = runpy.run_path(str(REPORTS / "methods" / "strengths.py"))
    return functions, functions["study"](REPORTS / "methods")


def strengths_scope() -> Iterator[str]:
    """What the study of every method holds."""
    _, found = _strengths()
    clouds = listing([f"{name} ({part.n_input.iloc[0]:,})" for name, part in found.table.groupby("input")])
    yield f"{found.table.label.nunique()} methods; clouds, with their points: {clouds};"
    yield f"{_percents(found.table.reduction)} removed; {found.n_cases} cases for each method."
    yield f"Made {_day(found.run)}."
    if (jobs := found.run.plan.get("jobs", 1)) > 1:
        yield f"{jobs} cases ran at the same time, so the seconds say which method is slow, and no more."


def strengths_winners() -> Iterator[str]:
    """Who has the first places by each measure."""
    functions, found = _strengths()
    yield from functions["winners"](found)


def strengths() -> Iterator[str]:
    """One paragraph for each method."""
    functions, found = _strengths()
    yield from functions["paragraphs"](found)


def strengths_speed() -> Iterator[str]:
    """The slowest methods, and the most memory."""
    functions, found = _strengths()
    yield from functions["speed"](found)


def strengths_failures() -> Iterator[str]:
    """The cases of the study of every method that have no result."""
    functions, found = _strengths()
    yield from functions["failures"](found)


def seeds() -> Iterator[str]:
    """How much the seed decides, from reports/seeds."""
    if not (REPORTS / "seeds" / "run.json").exists():
        yield "This study has no committed result yet: `python reports/make.py --models FOLDER --only seeds` makes it."
        return
    run = load_run(REPORTS / "seeds")
    functions = runpy.run_path(str(REPORTS / "seeds" / "spread.py"))
    yield from functions["spread"](run, {key: _strengths()[0]["MEASURES"][key] for key in GOALS})
    yield f"Every case is in [records.csv](../reports/seeds/records.csv), made {_day(run)}."


def times() -> Iterator[str]:
    """Seconds on the bunny, from reports/bunny."""
    run = load_run(REPORTS / "bunny")
    table = cells(run.frame)
    last = table[table.reduction.eq(table.reduction.max())].set_index("label")
    rows = [[f"`{m}`", f"{last.at[m, 'runtime_s']:.3g}"] for m in TIMED if m in last.index]
    yield from markdown_table(["method", "seconds of the call"], rows, "---")
    yield ""
    yield f"{int(run.frame.n_input.iloc[0]):,} points, {_percents(last.reduction)} removed, {run.environment['cores']}"
    yield f"cores. From [reports/bunny](../reports/bunny/README.md), made {_day(run)}."


def bunny() -> Iterator[str]:
    """The last table of the main job, from reports/bunny."""
    yield from ("```text", format_run(load_run(REPORTS / "bunny")).split("\n\n")[2].rstrip(), "```")


def _by_script(script: str, function: str) -> Iterator[str]:
    """What a function of a script under reports/ yields, or returns as one text."""
    lines = runpy.run_path(str(REPORTS / script))[function]()
    yield from [lines] if isinstance(lines, str) else lines


def made() -> Iterator[str]:
    """When, where and in how many seconds each study was made, as reports/make.py has noted it."""
    noted = json.loads((REPORTS / "made.json").read_text(encoding="utf-8"))
    rows = [
        [f"`{name}`", row["commit"][:12], row["date"], row["machine"], f"{row['seconds']:,}"]
        for name, row in noted.items()
        if "commit" in row
    ]
    yield from markdown_table(["step", "commit", "made", "machine", "wall time, s"], rows, "---")


def claims() -> Iterator[str]:
    """The README's table."""
    yield from _by_script("claims.py", "table")


def evidence() -> Iterator[str]:
    """The README's table, for a page of this folder."""
    for table in claims():
        yield table.replace("](reports/", "](../reports/")


def command() -> Iterator[str]:
    """The help texts of the command."""
    app = typer.main.get_command(build_app())
    for name in sorted(getattr(app, "commands", {})):
        result = CliRunner().invoke(build_app(), [name, "--help"], prog_name="lpcompare", color=False)
        yield from (
            f"## lpcompare {name}",
            "",
            "```text",
            *map(str.rstrip, result.output.strip().splitlines()),
            "```",
            "",
        )


def python() -> Iterator[str]:
    """One entry for every public name, at its home."""
    for name in lpcompare.__all__:
        if home := lpcompare._HOMES.get(name):
            yield from (
                f"::: lpcompare.{home}.{name}",
                "    options:",
                f"      heading: lpcompare.{name}",
                "",
            )


def metrics() -> Iterator[str]:
    """Every column of every metric."""
    rows = [
        [
            f"`{row.metric}`",
            f"`{key}`",
            row.title,
            row.unit,
            row.better,
            f"`{row.alias}`" if row.alias else "",
        ]
        for key, row in lpcompare.metrics().iterrows()
    ]
    yield from markdown_table(
        ["metric", "column", "what it is", "unit", "better", "follows from"], rows, "---"
    )
    slow = [name for name in METRICS if name not in METRICS.quick]
    yield f"\nSlow, and only on request (`--metric NAME`): {', '.join(f'`{name}`' for name in slow)}."


def models() -> Iterator[str]:
    """The catalogue."""
    rows = [
        [f"`{name}`", f"{m.points:,}", m.title, _origin(m), m.licence, m.cite]
        for name, m in catalogue().items()
    ]
    yield from markdown_table(["model", "points", "what it is", "where from", "licence", "cite"], rows, "---")


PARTS = {
    f.__name__: f
    for f in (
        choice,
        inputs,
        reach,
        settings,
        uniform,
        damaged,
        strengths,
        strengths_scope,
        strengths_winners,
        strengths_speed,
        strengths_failures,
        seeds,
        times,
        bunny,
        claims,
        evidence,
        made,
        command,
        python,
        metrics,
        models,
    )
}


SCRIPTS = {
    "claims.py": {"index": "index"},
    "benchmarks/draw.py": {"benchmarks": "table", "ratios": "ratios"},
    "large/tables.py": {name: name for name in ("seams", "stages", "hours", "rivals")},
}
"""Parts that a script under reports/ makes: the name of each, and the function."""

PARTS |= {
    part: partial(_by_script, script, function)
    for script, parts in SCRIPTS.items()
    for part, function in parts.items()
}


def pages() -> Iterator[tuple[Path, str]]:
    """Every page with a made part, and the text that it should have."""
    yield DOCS / "methods.md", runpy.run_path(str(DOCS / "methods_page.py"))["method_page"]()
    reports = [REPORTS / folder / "README.md" for folder in (".", "uniform", "benchmarks")]
    for path in [DOCS.parent / "README.md", *sorted(DOCS.rglob("*.md")), *reports]:
        text = path.read_text(encoding="utf-8")
        made = PART.sub(lambda m: m[1] + "\n" + "\n".join(PARTS[m[2]]()).rstrip() + "\n\n" + m[3], text)
        if PART.search(text):
            yield path, made


def _best(means: object, moves: bool | None, mesh: bool) -> str:
    """The method of one kind with the least mean, and the mean."""
    fits = {
        m: float(v)
        for m, v in means.items()  # type: ignore[attr-defined]
        if METHODS.traits(m).needs_mesh == mesh
        and moves in (None, METHODS.traits(m).moves_points)
        and not math.isnan(v)
    }
    name = min(fits, key=lambda m: fits[m])
    return f"`{name}` ({fits[name]:.2f})"


def _place(row: list[str]) -> int:
    known = list(CLOUDS)
    return known.index(row[0]) if row[0] in known else len(known)


def _percents(reductions: object) -> str:
    return ", ".join(f"{100 * r:.0f} %" for r in sorted(set(reductions)))  # type: ignore[call-overload]


def _day(run: object) -> str:
    version = run.environment["packages"].get("lpcompare", "an unknown version")  # type: ignore[attr-defined]
    return f"{str(run.environment['started'])[:10]} with lpcompare {version}"  # type: ignore[attr-defined]


def _origin(model: object) -> str:
    return f"made by `{model.made_by}`" if model.made_by else model.source  # type: ignore[attr-defined]


def main() -> None:
    """Write every page that differs and say which."""
    for path, text in pages():
        if path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            sys.stdout.write(f"{path.relative_to(DOCS.parent)}\n")


if __name__ == "__main__":
    main()
