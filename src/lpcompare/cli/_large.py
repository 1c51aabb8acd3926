"""The path of ``lpcompare simplify`` for clouds larger than memory."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer

from lpcompare.cli._bar import Callback
from lpcompare.cli._say import complain, say

INTERRUPTED = 130
Memory = Annotated[
    str | None, typer.Option(help="Memory of all processes, such as 4GiB; by default half of what is free.")
]
Workers = Annotated[int, typer.Option(help="Processes for the tiles (Dask); 0 is none.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="A running Dask scheduler, such as tcp://host:8786.")
]
_UNITS = {"": 0, "K": 10, "M": 20, "G": 30, "T": 40}


@dataclass(frozen=True)
class Large:
    """The options of this path, as they were given."""

    tiles: int | None
    memory: str | None
    spill: Path | None
    resume: bool
    workers: int
    scheduler: str | None

    def check(self) -> None:
        """Raise an `InputError` where an option has no meaning, also if it is not needed."""
        from lpcompare.checks import check_integer

        if self.memory is not None:
            parse_size(self.memory)
        if self.tiles is not None:
            check_integer("--tiles", self.tiles, 1)
        check_integer("--workers", self.workers, 0)

    def wanted(self, inputs: list[str], out: str) -> bool:
        """Whether an option, a URL, or one file for several inputs asks for this path."""
        from lpcompare.tiles.fetch import is_url
        from lpcompare.tiles.streams import STREAMS

        if len(inputs) > 1 and Path(out).suffix.lower() in STREAMS and not Path(out).is_dir():
            return True

        options = (self.tiles is not None, self.resume, self.workers, self.scheduler, self.spill is not None)
        return any(options) or any(map(is_url, inputs))

    @property
    def memory_bytes(self) -> int:
        """What all processes may use together."""
        from lpcompare.large.estimate import free_memory

        return free_memory() // 2 if self.memory is None else parse_size(self.memory)

    def needed(self, path: Path, method: str) -> bool:
        """Whether a file would not fit into memory, and can be read in parts."""
        from lpcompare.errors import InputError
        from lpcompare.large.estimate import in_memory_bytes
        from lpcompare.registry import METHODS
        from lpcompare.tiles.streams import STREAMS, count_points

        if path.suffix.lower() not in STREAMS or not path.is_file() or not METHODS.traits(method).in_tiles:
            return False
        try:
            return in_memory_bytes(method, count_points(path)) > self.memory_bytes
        except (InputError, OSError):  # the reader of whole files says better what is wrong with it
            return False


def parse_size(text: str) -> int:
    """Bytes of a size such as 4GiB, 512MiB or 2G; raises `InputError`."""
    from lpcompare.errors import InputError

    found = re.fullmatch(r"([0-9]+(?:[.][0-9]+)?) ?([KMGT]?)(?:i?B)?", text.strip(), re.IGNORECASE)
    size = int(float(found[1]) * 2 ** _UNITS[found[2].upper()]) if found else 0
    if not size:
        raise InputError(f"--memory is {text!r}; give a size such as 4GiB or 512MiB.")
    return size


@contextmanager
def some_cluster(workers: int, scheduler: str | None) -> Iterator[Any]:
    """A Dask client where one is asked for, whose dashboard is named on stderr; else None."""
    from lpcompare.large.cluster import local_client, remote_client

    if not workers and not scheduler:
        yield None
        return
    with remote_client(scheduler) if scheduler else local_client(workers) as client:
        say(f"Dask's dashboard: {client.dashboard_link}", err=True)
        yield client


def simplify_large(
    inputs: list[str],
    out: str,
    large: Large,
    *,
    how_far: dict[str, Any],
    method: str,
    settings: dict[str, Any],
    seed: int,
    callback: Callback,
) -> str:
    """Thin all inputs together; returns the report."""
    from lpcompare.errors import InputError
    from lpcompare.large.simplify_files import simplify_files

    if set(how_far) - {"statistic"} - {"target_reduction", "target_count"}:
        raise InputError(
            "--max-error and --tolerance need the whole cloud; give --reduction or --count for tiles."
        )
    begin = perf_counter()
    with some_cluster(large.workers, large.scheduler) as client:
        try:
            result = simplify_files(
                inputs,
                out,
                **{name: value for name, value in how_far.items() if name != "statistic"},
                method=method,
                n_tiles=large.tiles,
                memory=large.memory_bytes,
                spill=large.spill,
                resume=large.resume,
                random_state=seed,
                callback=callback,
                client=client,
                **settings,
            )
        except KeyboardInterrupt as error:
            complain(f"Interrupted. {error}")
            raise typer.Exit(INTERRUPTED) from None
    names = f"{len(inputs)} inputs" if len(inputs) > 1 else Path(inputs[0]).name
    line = (
        f"{names}: {result.n_points:,} -> {result.n_kept:,} points by {method} in {result.n_tiles} tiles, "
        f"spill {result.spill_mib:,.0f} MiB, {perf_counter() - begin:.2f} s in all"
    )
    return "; ".join([line, *result.notes])
