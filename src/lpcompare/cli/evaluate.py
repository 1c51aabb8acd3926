"""``lpcompare evaluate``: how well a thinned file represents the files that it was made from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lpcompare.cli._bar import stage_bar
from lpcompare.cli._large import INTERRUPTED, Large, Memory, Scheduler, Workers, parse_size, some_cluster
from lpcompare.cli._say import say

Paths = Annotated[
    list[str],
    typer.Argument(metavar="ORIGINAL... REDUCED", help="The files as they were, and the thinned one."),
]
Tiles = Annotated[int | None, typer.Option(help="Tiles on disk; by default as memory allows.")]
Spill = Annotated[Path | None, typer.Option(help="Folder for the tiles, by default beside REDUCED.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress.")]


def command(
    paths: Paths,
    *,
    tiles: Tiles = None,
    memory: Memory = None,
    spill: Spill = None,
    workers: Workers = 0,
    scheduler: Scheduler = None,
    quiet: Quiet = False,
) -> None:
    """Measure what a thinned cloud has lost.

    Plane error, distances and normals, for clouds of any size.

    Example: lpcompare evaluate scan.laz thin.laz
    """
    from lpcompare.errors import InputError
    from lpcompare.large.evaluate_files import evaluate_files

    if len(paths) < 2:
        raise InputError("Name at least one original and then the reduced file.")
    Large(tiles, memory, spill, False, workers, scheduler).check()
    with (
        some_cluster(workers, scheduler) as client,
        stage_bar(hidden=quiet) as callback,
    ):
        try:
            values = evaluate_files(
                paths[:-1],
                paths[-1],
                n_tiles=tiles,
                memory=None if memory is None else parse_size(memory),
                spill=spill,
                callback=callback,
                client=client,
            )
        except KeyboardInterrupt:
            raise typer.Exit(INTERRUPTED) from None
    width = max(map(len, values))
    for name, value in values.items():
        say(f"{name:<{width}}  {value:.6g}")
