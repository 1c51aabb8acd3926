"""``lpcompare run``: methods side by side on the same clouds, at equal counts."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from datetime import datetime
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lpcompare.cli import _complete
from lpcompare.cli._say import say

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lpcompare.benchmark.plan import Plan
    from lpcompare.benchmark.record import Run
    from lpcompare.cli._progress import Estimate, RunProgress
    from lpcompare.types import PointCloud

EXIT_NOT_ALL_OK = 1
EXIT_STOPPED = 130
Many = list[str] | None

Model = Annotated[
    Many,
    typer.Option(
        "--model", metavar="NAME", help="A name, or a file. May be repeated.", autocompletion=_complete.models
    ),
]
Method = Annotated[
    Many,
    typer.Option(
        "--method",
        metavar="NAME",
        help="May be repeated; 'all': every one installed. Default: 17.",
        autocompletion=_complete.methods_or_all,
    ),
]
Reduction = Annotated[
    list[float] | None,
    typer.Option("--reduction", metavar="SHARE", help="Share removed. Default: 0.7, 0.8, 0.9."),
]
Repeats = Annotated[int | None, typer.Option(help="Runs of each case, interleaved. Default: 1.")]
Seed = Annotated[list[int] | None, typer.Option("--seed", metavar="N", help="May be repeated. Default: 0.")]
Assignments = Annotated[
    Many,
    typer.Option(
        "--set",
        metavar="METHOD.NAME=VALUE",
        help="A setting of a method.",
        autocompletion=_complete.method_settings,
    ),
]
Metric = Annotated[
    Many,
    typer.Option(
        "--metric",
        metavar="NAME",
        help="A slow metric beside the quick ones, or 'all'.",
        autocompletion=_complete.slow_metrics,
    ),
]
Study = Annotated[
    str,
    typer.Option(
        metavar="FILE|PRESET",
        autocompletion=_complete.studies,
        help="A TOML file, or: smoke, default, paper, robustness, clusters, scaling, methods.",
    ),
]
Protocol = Annotated[
    str | None, typer.Option(help="equal-count (default) or as-printed.", autocompletion=_complete.protocols)
]
Refine = Annotated[bool | None, typer.Option("--refine", help="Refine every result that is a subset.")]
Out = Annotated[Path | None, typer.Option(help="Folder of the run. Default: reports/local/<time>-<name>.")]
TimeLimit = Annotated[float | None, typer.Option(help="Seconds of a case. Default: 300.")]
MemoryLimit = Annotated[
    int | None, typer.Option(help="MiB of a case. Default: three quarters of the machine's.")
]
Threads = Annotated[int | None, typer.Option(help="Threads of a case. Default: all processors.")]
Jobs = Annotated[int, typer.Option(help="Cases at once; above 1 the runtimes are unreliable.")]
Resume = Annotated[bool, typer.Option("--resume", help="Continue the run in --out; finished cases are kept.")]
Strict = Annotated[
    bool, typer.Option("--strict", help="Refuse models with points that have no finite coordinates.")
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Print the plan and stop.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress.")]


def command(
    *,
    model: Model = None,
    method: Method = None,
    reduction: Reduction = None,
    repeats: Repeats = None,
    seed: Seed = None,
    assignments: Assignments = None,
    metric: Metric = None,
    study: Study = "",
    protocol: Protocol = None,
    refine: Refine = None,
    out: Out = None,
    time_limit: TimeLimit = None,
    memory_limit: MemoryLimit = None,
    threads: Threads = None,
    jobs: Jobs = 1,
    resume: Resume = False,
    strict: Strict = False,
    dry_run: DryRun = False,
    quiet: Quiet = False,
) -> None:
    """Compare methods: errors, runtimes, a page.

    Every method thins every model to the same numbers of points.

    The exit code is 0 when every case is ok, 1 when one is not, 2 when none could be run, 130 after Ctrl-C.

    Example: lpcompare run --model scan.ply --method lp_uniform --method poisson_disk --reduction 0.9
    """
    from lpcompare.benchmark.runner import load_models
    from lpcompare.errors import InputError

    if resume and out is None:
        raise InputError("--resume continues a run; say which one with --out.")
    flags = {
        "models": model,
        "methods": method,
        "reductions": reduction,
        "seeds": seed,
        "repeats": repeats,
        "metrics": metric,
        "protocol": protocol,
        "refine": refine,
        "time_limit_s": time_limit,
    }
    machine = {"memory_limit_mib": memory_limit, "threads": threads, "jobs": jobs}
    plan = _plan(study, flags, assignments or [], machine)
    models = load_models(plan.models, strict=strict, tell=lambda sentence: say(sentence, err=True))
    if dry_run:
        say(_description(plan, models))
        return
    name = Path(study).stem or "-".join(cloud.name for cloud in models.values())
    done = _run(plan, models, out or _default_folder(name), resume=resume, quiet=quiet)
    if any(record.status != "ok" for record in done.records):
        raise typer.Exit(EXIT_NOT_ALL_OK)


def _default_folder(name: str) -> Path:
    from lpcompare.benchmark.run_folder import file_name

    return Path("reports/local") / f"{datetime.now():%Y%m%d-%H%M%S}-{file_name(name)}"


def _plan(study: str, flags: dict[str, Any], assignments: list[str], machine: dict[str, Any]) -> Plan:
    """The plan: flags go before the study, the study before the defaults."""
    from lpcompare.benchmark.study import build_plan, choose_methods, read_study
    from lpcompare.cli._settings import parse_assignments
    from lpcompare.errors import InputError

    fields: Any = dict(read_study(study)) if study else {}
    settings = fields.pop("settings", {})
    if flags["methods"]:
        settings = {name: chosen for name, chosen in settings.items() if name in flags["methods"]}
    flags = {name: value for name, value in flags.items() if value not in (None, [])}
    if fields.keys() & flags.keys():
        fields.pop("title", None)  # it speaks of the study as it is written
    fields |= flags
    if not fields.get("models"):
        raise InputError("No model is named; say for example --model bunny.")
    for name, chosen in parse_assignments(assignments, choose_methods(fields.get("methods"))).items():
        settings[name] = {**settings.get(name, {}), **chosen}
    return build_plan(fields | {"settings": settings}, **machine)


def _run(plan: Plan, models: Mapping[str, PointCloud], folder: Path, *, resume: bool, quiet: bool) -> Run:
    """Run the plan, print its table and write its page."""
    from lpcompare.benchmark.runner import run_plan, silent
    from lpcompare.registry import METHODS
    from lpcompare.report.tables import format_run

    for note in METHODS.notes:
        say(note, err=True)
    try:
        hidden = quiet or not sys.stderr.isatty()
        with nullcontext(silent) if hidden else _progress(plan, models) as listener:
            run = run_plan(plan, models, folder, resume=resume, listener=listener, meanwhile=_import_page)
    except KeyboardInterrupt:
        say(f"\nStopped. Continue with the same command and --resume --out {folder}", err=True)
        raise typer.Exit(EXIT_STOPPED) from None
    if run.n_damaged:
        lost = _count(run.n_damaged, "damaged record")
        say(f"{lost} of the earlier start could not be read; the cases were run again.", err=True)
    say(format_run(run))
    say(f"\nThe run is in {folder}; look at it in {run.report()}.")
    return run


def _import_page() -> None:
    """Import what the page takes."""
    for name in (
        "lpcompare.report.page",
        "matplotlib.figure",
        "matplotlib.backends.backend_agg",
        "plotly.offline",
        "scipy.spatial",
    ):
        import_module(name)


def _progress(plan: Plan, models: Mapping[str, PointCloud]) -> RunProgress:
    """Say how much there is to do, and go on saying how much is left."""
    from lpcompare.cli._progress import RunProgress

    estimate = _estimate(plan, models)
    say(_size(plan, estimate), err=True)
    return RunProgress(list(plan.cases()), estimate)


def _estimate(plan: Plan, models: Mapping[str, PointCloud]) -> Estimate:
    from lpcompare.cli._progress import Estimate, start_seconds

    return Estimate({name: len(cloud) for name, cloud in models.items()}, plan.jobs, start_seconds())


def _size(plan: Plan, estimate: Estimate) -> str:
    from lpcompare.cli._progress import duration

    return f"{_count(len(plan), 'case')}, about {duration(estimate.remaining_s(plan.cases()))}"


def _description(plan: Plan, models: Mapping[str, PointCloud]) -> str:
    """The plan in words, for --dry-run."""
    from lpcompare.checks import target_from_reduction
    from lpcompare.registry import METHODS

    lines = [_size(plan, _estimate(plan, models)), "", "models:"]
    for cloud in models.values():
        counts = ", ".join(
            f"{target_from_reduction(len(cloud), r):,} ({100 * r:g} % removed)" for r in plan.reductions
        )
        lines.append(f"  {cloud.name}: {counts} of {len(cloud):,} points")
    lines.append("methods:")
    lines += [f"  {v.label}  {METHODS.missing(v.method)}".rstrip() for v in plan.variants]
    if len(plan.perturbations) > 1:
        lines.append("input: " + ", ".join(p.label or "clean" for p in plan.perturbations))
    seeds = ", ".join(map(str, plan.seeds))
    work = f"{_count(plan.repeats, 'repeat')}, {_count(plan.threads, 'thread')}"
    lines.append(f"protocol {plan.protocol}, seeds {seeds}, {work}")
    lines.append(f"metrics: {', '.join(plan.metrics)}")
    return "\n".join(lines)


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}{'s' * (n != 1)}"
