"""`voxel_nearest` of files: the same cubes and the same points as in memory.

The search for the edge sees the counts of the whole cloud: a tile counts the cubes that are its own, and the few
that a cut goes through are counted together. In the end a cube belongs to the first of the tiles that have a point
in it. That tile looks at all points of the cube, in input order.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.tiles.job import Arrays, Job
from lpcompare.tiles.tiles import Run, around, bounds_of, spilling, take, tile_tasks
from lpcompare.types import Indices, Mask, Points
from lpcompare_baselines._calibration import search_size, surface_spacing
from lpcompare_baselines._cells import cell_means, finest_cell
from lpcompare_baselines._clusters import nearest_members


def stages(job: Job, run: Run) -> None:
    """Search the edge that gives the count, with a stage for every probe; keep."""
    spilling(job, run)
    edge = job.settings.get("cell_size")
    if edge is None:
        corners = np.stack([job.load("whole")["low"], job.load("whole")["high"]])
        start = surface_spacing(corners, job.target_count)
        finest = finest_cell(corners)
        size = search_size(lambda size: count_occupied(job, run, max(size, finest)), job.target_count, start)
        edge = max(size, finest)
    job.save("edge", edge=edge)
    run("selection", tile_tasks(job, keep, "chosen"))


def summary(job: Job) -> dict[str, Any]:
    """The edge of a cube, in model units."""
    return {"cell_size": float(job.load("edge")["edge"])}


def count_occupied(job: Job, run: Run, edge: float) -> int:
    """Occupied cubes of the whole cloud."""
    name = f"cubes-{edge.hex()}"
    task = partial(count_cubes, name=name, edge=edge)
    run("calibration", tile_tasks(job, task, name))
    parts = [job.load(name, tile) for tile in range(job.n_tiles)]
    shared = np.unique(np.concatenate([part["shared"] for part in parts]))
    return int(sum(part["count"] for part in parts)) + len(shared)


def count_cubes(job: Job, tile: int, *, name: str, edge: float) -> None:
    """Count the cubes that lie between the cuts around a tile; save those that a cut goes through.

    A cube between the cuts has points of this tile alone, so that no other tile is read.
    """
    whole = job.load("whole")
    cubes = _cube_of(np.asarray(job.map_array("points", tile)), whole, edge)
    low, high = (_cube_of(end, whole, edge) for end in bounds_of(whole, tile, 2 * edge))
    cut = (cubes <= low).any(axis=1) | (cubes >= high).any(axis=1)
    numbers = _number(cubes, whole, edge)
    job.save(name, tile, count=len(np.unique(numbers[~cut])), shared=np.unique(numbers[cut]))


def _cube_of(points: Points, whole: Arrays, edge: float) -> NDArray[np.int64]:
    """Places of cubes along the axes, shape of ``points``."""
    return ((points - whole["low"]) / edge).astype(np.int64)


def _number(cubes: NDArray[np.int64], whole: Arrays, edge: float) -> NDArray[np.int64]:
    """One number for each cube, shape (n,)."""
    _, along_y, along_z = _cube_of(whole["high"], whole, edge) + 1
    return (cubes[:, 0] * along_y + cubes[:, 1]) * along_z + cubes[:, 2]


def _cubes(job: Job, tile: int, edge: float) -> tuple[Points, Indices, Indices, Mask]:
    """Points in and around a tile in input order, their rows, the cube of each, and the cubes of the tile."""
    whole = job.load("whole")
    near = around(job, tile, 2 * edge)
    points = np.concatenate([job.map_array("points", tile), take(job, "points", near)])
    rows = np.concatenate([job.map_array("rows", tile), take(job, "rows", near)]).astype(np.intp)
    tiles = np.append(np.full(len(points) - len(near.tiles), tile), near.tiles)
    order = np.argsort(rows, kind="stable")
    cubes = np.unique(_number(_cube_of(points[order], whole, edge), whole, edge), return_inverse=True)[1]
    first = np.full(cubes.max(initial=-1) + 1, job.n_tiles)
    np.minimum.at(first, cubes, tiles[order])
    return points[order], rows[order], cubes, first == tile


def keep(job: Job, tile: int) -> None:
    """Of each cube of a tile, keep the point nearest to the mean of its points."""
    points, rows, cubes, own = _cubes(job, tile, float(job.load("edge")["edge"]))
    kept = rows[:0]
    if len(points):
        means, group = cell_means(points, cubes)
        nearest = nearest_members(points, group, means)
        kept = rows[nearest[own[cubes[nearest]]]]
    job.save_array("kept", tile, kept)
    job.save("chosen", tile, count=len(kept))
