"""The last pass: the kept rows of every file, in input order, with all that the file says of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from lpcompare.progress import Callback
from lpcompare.tiles.job import Block, Job
from lpcompare.tiles.streams import note_on, read_rows, writer
from lpcompare.types import Indices


def write_kept(
    job: Job, output: Path, callback: Callback | None = None, check: Callable[[], object] = lambda: None
) -> tuple[int, tuple[Path, ...], tuple[str, ...]]:
    """Write the kept rows to one file, or to a folder with a file for every input.

    Parameters
    ----------
    job : Job
        Every tile (or block) has left ``kept``: its rows of the input, ascending.
    output : Path
        A folder that exists, or a file.
    callback : callable, optional
    check : callable, optional
        Raises where the rows may not take their place after all.

    Returns
    -------
    n_kept : int
    outputs : tuple of Path
    notes : tuple of str
        What the output lacks.
    """
    parts = sorted((job.folder / "kept").glob("[0-9]*.npy"))
    kept = [np.load(part, mmap_mode="r") for part in parts]
    if output.is_dir():
        groups = [(output / path.name, [b for b in job.blocks if b.path == path]) for path, _ in job.inputs]
    else:
        groups = [(output, list(job.blocks))]
    for target, blocks in groups:
        _write(target, blocks, kept, len(job.blocks), callback, check)
    notes = dict.fromkeys(note for path, _ in job.inputs if (note := note_on(path)))
    return sum(map(len, kept)), tuple(target for target, _ in groups), tuple(notes)


def _write(
    target: Path,
    blocks: list[Block],
    kept: list[Indices],
    n_blocks: int,
    callback: Callback | None,
    check: Callable[[], object],
) -> None:
    chosen = [_rows_of(block, kept) for block in blocks]
    with writer(target, blocks[0].path, sum(map(len, chosen))) as append:
        for block, rows in zip(blocks, chosen, strict=True):
            if len(rows):
                append(block.path, read_rows(block.path, block.start, block.stop)[1][rows])
            if callback:
                callback("writing", block.number + 1, n_blocks)
        check()


def _rows_of(block: Block, kept: list[Indices]) -> Indices:
    """Places in a block of the rows that are kept, ascending."""
    end = block.before + block.stop - block.start
    parts = [rows[slice(*np.searchsorted(rows, [block.before, end]))] for rows in kept]
    return np.sort(np.concatenate(parts)) - block.before
