"""``lpcompare simplify``: read, thin, write; everything that a file says about the kept points stays."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lpcompare.cli import _complete
from lpcompare.cli._bar import Callback, stage_bar
from lpcompare.cli._large import Large, Memory, Scheduler, Workers, simplify_large
from lpcompare.cli._say import complain, say

if TYPE_CHECKING:
    import numpy as np

    from lpcompare.benchmark.isolation import Limits
    from lpcompare.types import PointCloud, Simplification

STANDARD_OUTPUT = "-"
_FACES_LEFT_OUT = "the result is a cloud, so that faces are left out"
_MOVED = "points were moved, so that only coordinates are written"
_JUDGED = 20_000
"""Original points at which the error of the report line is measured."""


@dataclass(frozen=True)
class _Order:
    """What is asked of every file."""

    method: str
    how_far: dict[str, Any]
    settings: dict[str, Any]
    limits: Limits | None
    seed: int
    strict: bool
    drop_outliers: float | None
    rank: bool
    refine: bool
    evaluate: bool


Paths = Annotated[
    list[str],
    typer.Argument(
        metavar="IN... OUT", help="Files to thin, and where to write: a file, '-' (PLY), or a folder."
    ),
]
Reduction = Annotated[float | None, typer.Option(help="Share of the points to remove.")]
Count = Annotated[int | None, typer.Option(help="Points to keep.")]
MaxError = Annotated[
    float | None, typer.Option(help="Largest plane error, % of the diagonal; keeps as few as allowed.")
]
Tolerance = Annotated[float | None, typer.Option(help="The same in the file's unit of length.")]
Statistic = Annotated[
    str, typer.Option(help="What the two bound: mean, p95 or max.", autocompletion=_complete.statistics)
]
Method = Annotated[str, typer.Option(help="See lpcompare list methods.", autocompletion=_complete.methods)]
Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="A setting of the method.", autocompletion=_complete.settings
    ),
]
Refine = Annotated[bool, typer.Option("--refine", help="Swap points afterwards for less error.")]
Rank = Annotated[bool, typer.Option("--order", help="Write the rank of each point (progressive methods).")]
Strict = Annotated[
    bool, typer.Option("--strict", help="Refuse points without coordinates; else they are left out.")
]
DropOutliers = Annotated[
    float | None,
    typer.Option(
        metavar="DEVIATIONS",
        help="Leave out points that lie alone by so many standard deviations; 2 is usual.",
    ),
]
Evaluate = Annotated[bool, typer.Option("--evaluate", help="Print every quick metric in full.")]
Seed = Annotated[int, typer.Option(help="Seed of every random draw.")]
Isolate = Annotated[bool, typer.Option("--isolate", help="Call the method in a child process.")]
TimeLimit = Annotated[
    float | None, typer.Option(help="Seconds after which a file is given up; implies --isolate.")
]
MemoryLimit = Annotated[int | None, typer.Option(help="MiB that the method may use; implies --isolate.")]
Tiles = Annotated[
    int | None,
    typer.Option(
        help="Work in so many tiles on disk, all inputs as one cloud; by itself where memory is short."
    ),
]
Spill = Annotated[Path | None, typer.Option(help="Folder for the tiles, by default beside OUT.")]
Resume = Annotated[bool, typer.Option("--resume", help="Continue from finished tiles.")]
Force = Annotated[bool, typer.Option("--force", help="Allow OUT to be an input.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress and no report.")]


def command(
    paths: Paths,
    *,
    reduction: Reduction = None,
    count: Count = None,
    max_error: MaxError = None,
    tolerance: Tolerance = None,
    statistic: Statistic = "mean",
    method: Method = "lp_uniform",
    assignments: Assignments = None,
    refine: Refine = False,
    rank: Rank = False,
    strict: Strict = False,
    drop_outliers: DropOutliers = None,
    evaluate: Evaluate = False,
    seed: Seed = 0,
    isolate: Isolate = False,
    time_limit: TimeLimit = None,
    memory_limit: MemoryLimit = None,
    tiles: Tiles = None,
    memory: Memory = None,
    spill: Spill = None,
    resume: Resume = False,
    workers: Workers = 0,
    scheduler: Scheduler = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Thin point clouds and keep their attributes.

    Example: lpcompare simplify scan.laz thin.laz --reduction 0.9
    """
    from lpcompare.checks import check_integer
    from lpcompare.cli._settings import parse_assignments
    from lpcompare.registry import METHODS

    METHODS.traits(method)
    chosen = parse_assignments([f"{method}.{word}" for word in assignments or ()], (method,))
    order = _Order(
        method=method,
        how_far=_how_far(reduction, count, max_error, tolerance) | {"statistic": statistic},
        settings=chosen.get(method, {}),
        limits=_limits(time_limit, memory_limit, isolate=isolate),
        seed=check_integer("seed", seed, 0),
        strict=strict,
        drop_outliers=drop_outliers,
        rank=rank,
        refine=refine,
        evaluate=evaluate,
    )
    large = Large(tiles, memory, spill, resume, workers, scheduler)
    large.check()
    _simplify_all(paths, order, large, force=force, quiet=quiet)


def _simplify_all(paths: list[str], order: _Order, large: Large, *, force: bool, quiet: bool) -> None:
    """Thin all inputs as one cloud where that is wanted, else each of them."""
    if not large.wanted(paths[:-1], paths[-1]):
        _simplify_each(_pairs(paths, force=force), order, large, quiet=quiet)
        return
    with stage_bar(hidden=quiet) as callback:
        report = _in_tiles(paths[:-1], paths[-1], order, large, callback)
    if not quiet:
        say(report)


def _simplify_each(pairs: list[tuple[Path, Path | str]], order: _Order, large: Large, *, quiet: bool) -> None:
    """Thin file after file; where there are several, one that fails does not stop the others."""
    from lpcompare.errors import LpcompareError

    failed = False
    for source, target in pairs:
        try:
            with stage_bar(hidden=quiet) as callback:
                if isinstance(target, Path) and large.needed(source, order.method):
                    report = _in_tiles([str(source)], str(target), order, large, callback)
                else:
                    report = _simplify_file(source, target, order, callback)
        except LpcompareError as error:
            if len(pairs) == 1:
                raise
            complain(str(error))
            failed = True
            continue
        if not quiet:
            say(report, err=target == STANDARD_OUTPUT)
    if failed:
        raise typer.Exit(2)


def _in_tiles(inputs: list[str], out: str, order: _Order, large: Large, callback: Callback) -> str:
    """Thin files together in tiles; returns the report."""
    from lpcompare.errors import InputError

    options = {
        "--order": order.rank,
        "--refine": order.refine,
        "--evaluate": order.evaluate,
        "--strict": order.strict,
        "--drop-outliers": order.drop_outliers is not None,
        "--isolate": order.limits is not None,
    }
    if given := [name for name, is_given in options.items() if is_given]:
        raise InputError(f"{given[0]} needs the whole cloud in memory; leave it out, or give more --memory.")
    return simplify_large(
        inputs,
        out,
        large,
        how_far=order.how_far,
        method=order.method,
        settings=order.settings,
        seed=order.seed,
        callback=callback,
    )


def _how_far(
    reduction: float | None, count: int | None, max_error: float | None, tolerance: float | None
) -> dict[str, Any]:
    """The one way that was chosen, by the names of `lpcompare.simplify`."""
    from lpcompare.errors import InputError

    ways = {
        "target_reduction": reduction,
        "target_count": count,
        "max_error": max_error,
        "tolerance": tolerance,
    }
    given = {name: value for name, value in ways.items() if value is not None}
    if len(given) != 1:
        raise InputError(
            "Say how much: either --reduction, a share such as 0.9, or --count, a number of points, "
            "or --max-error or --tolerance, the largest error."
        )
    return given


def _limits(time_limit: float | None, memory_limit: int | None, *, isolate: bool) -> Limits | None:
    """The limits of a child process, or None where none is asked for."""
    if time_limit is None and memory_limit is None and not isolate:
        return None
    from lpcompare.benchmark.isolation import Limits
    from lpcompare.checks import check_integer, check_number

    memory = None if memory_limit is None else check_integer("--memory-limit", memory_limit, 1)
    seconds = Limits.time_s if time_limit is None else check_number("--time-limit", time_limit, 1e-3)
    return Limits(seconds, memory)


def _simplify_file(source: Path, target: Path | str, order: _Order, callback: Callback) -> str:
    """Read, thin, write; returns the report."""
    from lpcompare.checks import check_points
    from lpcompare.files import state_of
    from lpcompare.io import read
    from lpcompare.simplify import simplify

    begin = perf_counter()
    callback("reading", 0, 0)
    state = state_of(source) if source.exists() else None  # without one, the reader says so
    cloud = read(source)
    if order.strict:
        check_points(cloud.points, source.name)
    callback(order.method, 0, 0)
    result = simplify(
        cloud,
        **order.how_far,
        method=order.method,
        drop_invalid=True,
        drop_outliers=order.drop_outliers,
        order=order.rank,
        random_state=order.seed,
        callback=callback,
        limits=order.limits,
        **order.settings,
    )
    if order.refine:
        result = _refined(cloud, result)
    callback("writing", 0, 0)
    with _output(target) as path:
        notes = _write(source, state, path, cloud, result, rank=order.rank)
    callback("error", 0, 0)
    line = _report(source, cloud, result, notes, begin)
    return line + (_evaluation(cloud, result) if order.evaluate else "")


def _refined(cloud: PointCloud, result: Simplification) -> Simplification:
    """The result after swaps of its points, where it is a subset."""
    from dataclasses import replace

    from lpcompare.errors import InputError
    from lpcompare.uniform.swaps import refine

    if result.indices is None:
        raise InputError(f"--refine swaps points of the input, and {result.method} makes new ones.")
    rows = _looked_at(cloud, result)
    begin = perf_counter()
    kept = rows[refine(cloud.points[rows], rows.searchsorted(result.indices))]
    seconds = (result.runtime_s or 0.0) + perf_counter() - begin
    return replace(result, points=cloud.points[kept], indices=kept, runtime_s=seconds)


def _looked_at(cloud: PointCloud, result: Simplification) -> np.ndarray:
    """The rows of the file that the method was given."""
    import numpy as np

    from lpcompare.checks import valid_rows

    given = valid_rows(cloud.points)
    given[result.info.get("outliers", [])] = False
    return np.flatnonzero(given)


def _write(
    source: Path,
    state: tuple[int, int, int] | None,
    path: Path,
    cloud: PointCloud,
    result: Simplification,
    *,
    rank: bool,
) -> list[str]:
    """Write the result; returns what of the input it lacks, for the report line."""
    from dataclasses import replace

    from lpcompare.io import keep_rows, same_format, write
    from lpcompare.types import PointCloud

    notes = [result.note] if result.note else []
    if n_left_out := result.info.get("n_left_out"):
        notes.append(f"{n_left_out:,} points without coordinates were left out")
    if n_outliers := len(result.info.get("outliers", ())):
        notes.append(f"{n_outliers:,} points that lie alone were left out")
    if result.indices is None:
        return [*notes, *write(path, PointCloud(result.points, name=cloud.name)), _MOVED]
    faces = [_FACES_LEFT_OUT] if cloud.faces is not None else []
    if same_format(source, path) and not rank:
        return [*notes, *keep_rows(source, path, result.indices, state), *faces]
    kept = cloud.take(result.indices)
    if rank:
        kept = replace(kept, attributes={**kept.attributes, "order": result.info["order"]})
    return [*notes, *write(path, kept), *faces]


def _report(source: Path, cloud: PointCloud, result: Simplification, notes: list[str], begin: float) -> str:
    """One line: counts, error, seconds, and what was lost."""
    from lpcompare.errors import printable

    error, diagonal, sampled = _plane_error(cloud, result)
    where = f" at {_JUDGED:,} sampled points" if sampled else ""
    share = f"{100 * error / diagonal:.4f} % of the diagonal" if diagonal else "no extent"
    seconds = f"{result.runtime_s or 0:.2f} s in the call"
    if result.calibration_s is not None:
        seconds += f", {result.calibration_s:.2f} s in its calibration"
    seconds += f", {perf_counter() - begin:.2f} s in all"
    return "; ".join(
        [
            f"{printable(source.name)}: {len(cloud):,} -> {len(result):,} points by {result.method}, "
            f"plane error (eq. 27) {share} ({error:.3g} model units){where}, {seconds}",
            *notes,
        ]
    )


def _plane_error(cloud: PointCloud, result: Simplification) -> tuple[float, float, bool]:
    """Mean plane error in model units, the diagonal, and whether a sample was judged."""
    import numpy as np

    from lpcompare.geometry.scale import bounding_box_diagonal
    from lpcompare.metrics.comparison import Comparison

    points = cloud.points[_looked_at(cloud, result)]
    diagonal = bounding_box_diagonal(points)
    sampled = len(points) > _JUDGED
    if sampled:
        points = points[np.random.default_rng(0).choice(len(points), _JUDGED, replace=False)]
    return float(Comparison(points, result.points).plane_errors(8).mean()), diagonal, sampled


def _evaluation(cloud: PointCloud, result: Simplification) -> str:
    """Every quick metric, one line each."""
    from lpcompare.metrics.comparison import evaluate

    values = evaluate(cloud.points[_looked_at(cloud, result)], result)
    width = max(map(len, values))
    return "".join(f"\n  {name:<{width}}  {value:.6g}" for name, value in values.items())


@contextmanager
def _output(target: Path | str) -> Iterator[Path]:
    """The file to write; for standard output one that is copied there afterwards."""
    if isinstance(target, Path):
        yield target
        return
    from lpcompare.processes.children import temporary_folder

    with temporary_folder() as folder:
        path = folder / "cloud.ply"
        yield path
        with path.open("rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)
        sys.stdout.buffer.flush()


def _pairs(paths: list[str], *, force: bool) -> list[tuple[Path, Path | str]]:
    """Each input with its output, checked before any work is done."""
    from lpcompare.errors import InputError
    from lpcompare.io import check_target
    from lpcompare.tiles.fetch import matches

    if len(paths) < 2:
        raise InputError("Name at least one input and then the output.")
    *inputs, out = paths
    sources = [Path(match) for word in inputs for match in matches(word)]
    if folder := next((source for source in sources if source.is_dir()), None):
        raise InputError(f"{folder} is a folder; name its files, such as '{folder}/*.laz'.")
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


def _folder(out: str) -> Path:
    """The folder for the results of several inputs, made if it is missing."""
    from lpcompare.errors import InputError

    if out == STANDARD_OUTPUT or Path(out).is_file():
        raise InputError(f"There are several inputs, so the output must be a folder, not {out!r}.")
    Path(out).mkdir(parents=True, exist_ok=True)
    return Path(out)


def _same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and os.path.samefile(target, source)
