"""``lpcompare run``: methods side by side on the same clouds, at equal counts."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

Many = list[str] | None


def command(
    *,
    model: Annotated[
        Many, typer.Option("--model", help="A model's name, or a file. May be repeated.")
    ] = None,
    method: Annotated[Many, typer.Option("--method", help="Default: all that are installed.")] = None,
    reduction: Annotated[
        list[float] | None, typer.Option("--reduction", help="Share removed. Default: 0.7, 0.8, 0.9.")
    ] = None,
    repeats: Annotated[int, typer.Option(help="Runs of each case, interleaved over the methods.")] = 1,
    seed: Annotated[int, typer.Option(help="Seed of every random draw.")] = 0,
    assignments: Annotated[
        Many, typer.Option("--set", metavar="METHOD.NAME=VALUE", help="A setting of a method.")
    ] = None,
    metric: Annotated[
        Many, typer.Option("--metric", help="A slow metric to add to the quick ones, or 'all'.")
    ] = None,
    refine: Annotated[bool, typer.Option("--refine", help="Refine every result that is a subset.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run. Default: reports/local/<time>-<model>.")
    ] = None,
    time_limit: Annotated[float, typer.Option(help="Seconds after which a case is killed.")] = 300.0,
    memory_limit: Annotated[
        int | None, typer.Option(help="MiB that a case may use. Default: three quarters of the machine's.")
    ] = None,
    threads: Annotated[int | None, typer.Option(help="Threads of a case. Default: all processors.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the run in --out.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress.")] = False,
) -> None:
    """Run methods side by side and print their errors and runtimes."""
    from lpcompare.errors import InputError
    from lpcompare.geometry.threads import thread_count
    from lpcompare.harness.environment import physical_memory_mib
    from lpcompare.harness.inputs import load_models
    from lpcompare.harness.plan import Plan, Variant, check_names, choose_metrics, default_methods
    from lpcompare.harness.runner import run_plan
    from lpcompare.harness.settings import parse_assignments
    from lpcompare.report.table import format_run

    if not model:
        raise InputError("No model is named; say for example --model bunny.")
    methods = tuple(method or default_methods())
    check_names(methods, ())
    chosen = parse_assignments(assignments or (), methods)
    plan = Plan(
        models=tuple(model),
        variants=tuple(Variant(name, chosen.get(name, {})) for name in methods),
        reductions=tuple(reduction or Plan.reductions),
        seeds=(seed,),
        repeats=repeats,
        metrics=choose_metrics(tuple(metric or ())),
        refine=refine,
        time_limit_s=time_limit,
        memory_limit_mib=memory_limit or physical_memory_mib() * 3 // 4,
        threads=threads or thread_count(),
    )
    plan.check()
    clouds = load_models(plan.models)
    titles = "-".join(cloud.name for cloud in clouds.values())
    folder = out or Path("reports/local") / f"{datetime.now():%Y%m%d-%H%M%S}-{titles}"
    run = run_plan(plan, clouds, folder, resume=resume)
    typer.echo(format_run(run))
    typer.echo(f"\nThe run is in {folder}.")
