"""What a thinning of files will need: tiles, disk, memory, time; said before it begins."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from lpcompare.checks import check_integer
from lpcompare.errors import InputError

_BYTES_IN_MEMORY = {"lp_uniform": 1000, "lp_density": 500, "lp_printed": 500}
_OTHER_BYTES_IN_MEMORY = 200
"""Peak bytes per point of a method on one tile, rounded up from measurements."""

_BYTES_ON_DISK = {"lp_uniform": 88, "lp_density": 82, "lp_printed": 82, "random_sample": 16}
_OTHER_BYTES_ON_DISK = 64
_HALO = 1.5
"""Points of a tile and around it, over those of the tile."""
_FIXED = 300 * 2**20
_LARGEST_TILE = 1_000_000
_SMALLEST_TILE = 2_000


@dataclass(frozen=True)
class Estimate:
    """What is foreseen.

    Attributes
    ----------
    n_tiles : int
    memory_mib, disk_mib : float
        Of all processes together, and of the spill folder at its largest.
    """

    n_tiles: int
    memory_mib: float
    disk_mib: float


def free_memory() -> int:
    """Bytes of memory that are free now."""
    import psutil

    return int(psutil.virtual_memory().available)


def in_memory_bytes(method: str, n_points: int) -> int:
    """Bytes that a method needs for a cloud as a whole, about."""
    return _FIXED + n_points * _BYTES_IN_MEMORY.get(method, _OTHER_BYTES_IN_MEMORY)


def estimate(method: str, n_points: int, memory: int | None, n_workers: int, n_tiles: int | None) -> Estimate:
    """Tiles, memory and disk.

    Parameters
    ----------
    method : str
    n_points : int
    memory : int, optional
        Bytes that all processes may use together; by default half of what is free.
    n_workers : int
    n_tiles : int, optional
        By default as few as the memory allows, with at most a million points each.

    Raises
    ------
    InputError
        The memory or the number of tiles is no positive integer, or the memory is too small for any tile.
    """
    memory = free_memory() // 2 if memory is None else check_integer("memory", memory, 1)
    n_tiles = None if n_tiles is None else check_integer("n_tiles", n_tiles, 1)
    each = int(_HALO * _BYTES_IN_MEMORY.get(method, _OTHER_BYTES_IN_MEMORY))
    room = memory // n_workers - _FIXED
    if n_tiles is None:
        tile_points = min(_LARGEST_TILE, room // each)
        if tile_points < min(_SMALLEST_TILE, n_points):
            least = (_FIXED + each * _SMALLEST_TILE) * n_workers / 2**20
            raise InputError(
                f"--memory is {memory / 2**20:.0f} MiB for {n_workers} processes; "
                f"give at least {least:.0f} MiB, or fewer workers."
            )
        n_tiles = max(1, -(-n_points // tile_points))
    largest = n_points / n_tiles * each + _FIXED
    on_disk = n_points * _BYTES_ON_DISK.get(method, _OTHER_BYTES_ON_DISK)
    return Estimate(n_tiles, n_workers * largest / 2**20, on_disk / 2**20)


def check_disk(folder: Path, needed_mib: float) -> None:
    """Raise an `InputError` where a folder has not the room that is needed."""
    place = folder
    while not place.exists():
        place = place.parent
    free = shutil.disk_usage(place).free / 2**20
    if free < needed_mib:
        raise InputError(
            f"{folder} needs about {needed_mib:.0f} MiB for the tiles and has {free:.0f} MiB; "
            "make room, or name another folder with --spill."
        )


def used_mib(folder: Path) -> float:
    """Size of all files of a folder."""
    sizes = (os.path.getsize(Path(root) / name) for root, _, names in os.walk(folder) for name in names)
    return sum(sizes) / 2**20
