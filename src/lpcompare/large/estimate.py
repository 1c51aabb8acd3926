"""What a thinning of files will need, known before it begins: memory, tiles, disk."""

from __future__ import annotations

import os
import shutil
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


def free_memory() -> int:
    """Bytes of memory that are free now."""
    import psutil

    return int(psutil.virtual_memory().available)


def in_memory_bytes(method: str, n_points: int) -> int:
    """Bytes that a method needs for a cloud as a whole, about."""
    return _FIXED + n_points * _BYTES_IN_MEMORY.get(method, _OTHER_BYTES_IN_MEMORY)


def choose_n_tiles(
    method: str, n_points: int, memory: int | None, n_workers: int, n_tiles: int | None
) -> int:
    """The tiles to work in.

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
    if n_tiles is not None:
        return check_integer("n_tiles", n_tiles, 1)
    each = int(_HALO * _BYTES_IN_MEMORY.get(method, _OTHER_BYTES_IN_MEMORY))
    room = memory // n_workers - _FIXED
    tile_points = min(_LARGEST_TILE, room // each)
    if tile_points < min(_SMALLEST_TILE, n_points):
        least = (_FIXED + each * _SMALLEST_TILE) * n_workers / 2**20
        raise InputError(
            f"--memory is {memory / 2**20:.0f} MiB for {n_workers} processes; "
            f"give at least {least:.0f} MiB, or fewer workers."
        )
    return max(1, -(-n_points // tile_points))


def check_disk(folder: Path, method: str, n_points: int) -> None:
    """Raise an `InputError` where a folder has not the room for the tiles of a method."""
    needed_mib, place = n_points * _BYTES_ON_DISK.get(method, _OTHER_BYTES_ON_DISK) / 2**20, folder
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
