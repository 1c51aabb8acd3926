"""``lpcompare evaluate``: how well a thinned file represents the files that it was made from."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from lpcompare.cli._bar import stage_bar
from lpcompare.cli._large import INTERRUPTED, Large, parse_size, some_cluster
from lpcompare.cli._say import say


def command(
    paths: Annotated[
        list[str],
        typer.Argument(metavar="ORIGINAL... REDUCED", help="The files as they were, and the thinned one."),
    ],
    *,
    tiles: Annotated[int | None, typer.Option(help="Tiles on disk; by default as memory allows.")] = None,
    memory: Annotated[
        str | None,
        typer.Option(help="Memory of all processes, such as 4GiB; by default half of what is free."),
    ] = None,
    spill: Annotated[
        Path | None, typer.Option(help="Folder for the tiles, by default beside REDUCED.")
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes for the tiles (Dask); 0 is none.")] = 0,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A running Dask scheduler, such as tcp://host:8786.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress.")] = False,
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
        stage_bar(shown=sys.stderr.isatty() and not quiet) as callback,
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
