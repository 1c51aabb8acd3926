"""What is asked for, the folder where its steps leave their results, and the blocks that files are read in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.files import CONTINUE, whole_file
from lpcompare.io.arrays import load_arrays, save_arrays

BLOCK_ROWS = 1_000_000
"""Rows that are read at once, a whole number of the chunks of a LAZ."""

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Block:
    """Some rows of one file, and how many rows of the whole input come before them."""

    number: int
    path: Path
    start: int
    stop: int
    before: int


@dataclass(frozen=True)
class Job:
    """One order; it travels to every task.

    Attributes
    ----------
    folder : Path
        Where every task leaves one file, which exists when the task is done.
    inputs : tuple of (Path, int)
        Files and their points.
    target_count : int
        Points to keep of all files together.
    method : str
    settings : mapping
        Every setting of the method.
    n_tiles : int
    seed : int
    block_rows : int
        The result does not depend on it.
    """

    folder: Path
    inputs: tuple[tuple[Path, int], ...]
    target_count: int
    method: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    n_tiles: int = 1
    seed: int = 0
    block_rows: int = BLOCK_ROWS

    @property
    def n_points(self) -> int:
        """Points of all files, those without coordinates among them."""
        return sum(count for _, count in self.inputs)

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks of all files, in input order."""
        blocks, before = list[Block](), 0
        for path, count in self.inputs:
            for start in range(0, count, self.block_rows):
                stop = min(start + self.block_rows, count)
                blocks.append(Block(len(blocks), path, start, stop, before + start))
            before += count
        return tuple(blocks)

    def path(self, name: str, number: int | None = None, ending: str = ".npz") -> Path:
        """The file of a result, one of the whole cloud or that of a block or tile."""
        return self.folder / (name + ending if number is None else f"{name}/{number}{ending}")

    def save(self, name: str, number: int | None = None, /, **arrays: Any) -> None:
        """Write arrays whole or not at all; raises `InputError` where the disk is full."""
        save_arrays(self.path(name, number), {key: np.asarray(value) for key, value in arrays.items()})

    def load(self, name: str, number: int | None = None) -> Arrays:
        """Read what `save` wrote; what is of the whole cloud stays in memory for the next task."""
        path = self.path(name, number)
        return (
            load_arrays(path)
            if number is not None or not path.exists()
            else _of_the_whole(path, _state(path))
        )

    def once(self, name: str, make: Callable[[Job], None]) -> None:
        """Call ``make``, which saves the result ``name`` of the whole cloud, unless it is there."""
        if not self.path(name).exists():
            make(self)

    def save_array(self, name: str, number: int, array: NDArray[Any]) -> None:
        """Write one array that `map_array` reads in parts."""
        path = self.path(name, number, ".npy")
        with whole_file(path, CONTINUE) as part, part.open("wb") as file:
            np.save(file, array)

    def map_array(self, name: str, number: int) -> NDArray[Any]:
        """An array on disk, read where it is looked at."""
        return np.load(self.path(name, number, ".npy"), mmap_mode="r")

    def gather(self, name: str) -> Arrays:
        """The results of all tiles, each array with a first axis for them."""
        parts = [self.load(name, tile) for tile in range(self.n_tiles)]
        return {key: np.stack([part[key] for part in parts]) for key in parts[0]}

    def sums(self, name: str) -> Arrays:
        """The results of all tiles, added up."""
        return {key: values.sum(axis=0) for key, values in self.gather(name).items()}


def _state(path: Path) -> tuple[int, int]:
    state = path.stat()
    return state.st_mtime_ns, state.st_ino


@lru_cache(maxsize=32)
def _of_the_whole(path: Path, _: tuple[int, int]) -> Arrays:
    return load_arrays(path)
