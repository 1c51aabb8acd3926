"""``lpcompare simplify``: thin files and keep everything that they say about the points that stay."""

from __future__ import annotations

import glob
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from lpcompare.benchmark.plan import Variant
    from lpcompare.benchmark.record import Record
    from lpcompare.types import Indices, PointCloud, Points

STANDARD_OUTPUT = "-"
_FACES_LEFT_OUT = "; the result is a cloud, so that faces are left out"


@dataclass(frozen=True)
class _Order:
    """What is asked of every file."""

    variant: Variant
    reduction: float | None
    count: int | None
    seed: int
    refine: bool
    time_limit: float


def command(
    paths: Annotated[
        list[str],
        typer.Argument(
            metavar="IN... OUT", help="Files to thin, and where to write: a file, '-' (PLY), or a folder."
        ),
    ],
    *,
    reduction: Annotated[float | None, typer.Option(help="Share of the points to remove.")] = None,
    count: Annotated[int | None, typer.Option(help="Points to keep, instead of a reduction.")] = None,
    method: Annotated[str, typer.Option(help="See lpcompare list.")] = "lp_uniform",
    assignments: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A setting of the method.")
    ] = None,
    refine: Annotated[bool, typer.Option("--refine", help="Exchange points for a smaller error.")] = False,
    seed: Annotated[int, typer.Option(help="Seed of every random draw.")] = 0,
    time_limit: Annotated[float, typer.Option(help="Seconds after which a file is given up.")] = 3600.0,
    force: Annotated[bool, typer.Option("--force", help="Allow OUT to be an input.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no report.")] = False,
) -> None:
    """Thin point clouds, keeping every attribute of their formats."""
    from lpcompare.benchmark.plan import Variant, check_names
    from lpcompare.benchmark.settings import parse_assignments
    from lpcompare.errors import InputError, LpcompareError

    if (reduction is None) == (count is None):
        raise InputError(
            "Say how much: either --reduction, a share such as 0.9, or --count, a number of points."
        )
    check_names((method,), ())
    chosen = parse_assignments([f"{method}.{word}" for word in assignments or ()], (method,))
    order = _Order(Variant(method, chosen.get(method, {})), reduction, count, seed, refine, time_limit)
    pairs = _pairs(paths, force=force)
    failed = False
    for source, target in _with_progress(pairs, quiet=quiet):
        try:
            line = _simplify_file(source, target, order)
        except LpcompareError as error:
            if len(pairs) == 1:
                raise
            sys.stderr.write(f"lpcompare: {error}\n")
            failed = True
            continue
        if not quiet:
            typer.echo(line, err=target == STANDARD_OUTPUT)
    if failed:
        raise typer.Exit(2)


def _simplify_file(source: Path, target: Path | str, order: _Order) -> str:
    """Read, reduce, write; returns the report line."""
    from lpcompare.io import read

    cloud = read(source)
    record, points, rows = _reduce(cloud, order)
    with _output(target) as path:
        note = _write(source, path, cloud, points, rows)
    error = record.metrics["plane_error_pct"], record.metrics["plane_error"]
    return (
        f"{source.name}: {len(cloud):,} -> {len(points):,} points by {record.method}, eq. 27 error "
        f"{error[0]:.4f} % of the diagonal ({error[1]:.3g} model units), {record.runtime_s:.2f} s{note}"
    )


def _reduce(cloud: PointCloud, order: _Order) -> tuple[Record, Points, Indices | None]:
    """Run one case of the harness: in a child process, timed, checked and judged."""
    from lpcompare.benchmark.environment import physical_memory_mib
    from lpcompare.benchmark.plan import Plan
    from lpcompare.benchmark.runner import run_plan
    from lpcompare.errors import InputError, LpcompareError
    from lpcompare.io.arrays import load_arrays
    from lpcompare.threads import thread_count
    from lpcompare.types import PointCloud

    n_points = len(cloud)
    if order.count is not None and not 1 <= order.count <= n_points:
        raise InputError(f"--count is {order.count}; {cloud.name} has {n_points} points, so 1 to {n_points}.")
    share = order.reduction if order.count is None else 1 - order.count / n_points
    plan = Plan(
        models=(cloud.name,),
        variants=(order.variant,),
        reductions=(0.0 if share is None else share,),
        seeds=(order.seed,),
        refine=order.refine,
        time_limit_s=order.time_limit,
        memory_limit_mib=physical_memory_mib() * 3 // 4,
        threads=thread_count(),
    )
    plan.check()
    given = PointCloud(cloud.points, cloud.normals, faces=cloud.faces, name=cloud.name)
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
        (record,) = run_plan(plan, {cloud.name: given}, Path(folder) / "run").records
        if record.status != "ok":
            raise LpcompareError(f"{order.variant.method} on {cloud.name}, {record.status}: {record.message}")
        arrays = load_arrays(Path(folder) / "run" / record.cloud)
    return record, arrays["points"], arrays.get("indices")


def _write(source: Path, path: Path, cloud: PointCloud, points: Points, rows: Indices | None) -> str:
    """Write the result and return what of the input it lacks, for the report line."""
    from lpcompare.io import keep_rows, same_format, write
    from lpcompare.types import PointCloud

    if rows is None:
        write(path, PointCloud(points, name=cloud.name))
        return "; points were moved, so that only coordinates are written"
    notes = keep_rows(source, path, rows) if same_format(source, path) else write(path, cloud.take(rows))
    return "".join(f"; {note}" for note in notes) + (_FACES_LEFT_OUT if cloud.faces is not None else "")


@contextmanager
def _output(target: Path | str) -> Iterator[Path]:
    """The file to write; for standard output one that is copied there afterwards."""
    if isinstance(target, Path):
        yield target
        return
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
        path = Path(folder) / "cloud.ply"
        yield path
        with path.open("rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)
        sys.stdout.buffer.flush()


def _pairs(paths: list[str], *, force: bool) -> list[tuple[Path, Path | str]]:
    """Each input with its output, checked before any work is done."""
    from lpcompare.errors import InputError
    from lpcompare.io import check_target

    if len(paths) < 2:
        raise InputError("Name at least one input and then the output.")
    *inputs, out = paths
    sources = [Path(match) for word in inputs for match in _matches(word)]
    if len(sources) == 1 and out == STANDARD_OUTPUT:
        return [(sources[0], out)]
    if len(sources) == 1 and not Path(out).is_dir():
        targets = [Path(out)]
    else:
        targets = [_folder(out) / source.name for source in sources]
    if len(set(targets)) < len(targets):
        raise InputError(f"Two inputs have the same name and would share a file in {out}; rename one.")
    for target in targets:
        check_target(target)
        if not force and any(_same(target, source) for source in sources):
            raise InputError(
                f"{target} is an input and would be replaced; name another file, or say --force."
            )
    return list(zip(sources, targets, strict=True))


def _matches(word: str) -> list[str]:
    """The files of a pattern that the shell has left alone, sorted; any other word as it is."""
    if Path(word).exists() or not glob.has_magic(word):
        return [word]
    found = sorted(glob.glob(word))
    if not found:
        from lpcompare.errors import InputError

        raise InputError(f"No file matches {word!r}.")
    return found


def _folder(out: str) -> Path:
    """The folder for the results of several inputs, made if it is missing."""
    from lpcompare.errors import InputError

    if out == STANDARD_OUTPUT or Path(out).is_file():
        raise InputError(f"There are several inputs, so the output must be a folder, not {out!r}.")
    Path(out).mkdir(parents=True, exist_ok=True)
    return Path(out)


def _same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and os.path.samefile(target, source)


def _with_progress(pairs: list[tuple[Path, Path | str]], *, quiet: bool) -> Iterator[tuple[Path, Path | str]]:
    """The pairs, with a bar and the remaining time on stderr where that is a terminal."""
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True)
    hidden = quiet or not console.is_terminal
    yield from track(pairs, "Thinning", console=console, transient=True, disable=hidden)
