"""`voxel_nearest` of files: the same cubes and the same points as in memory.

A cube belongs to the first of the tiles that have a point in it. That tile looks at all points of the cube, in
input order. So every cube is counted once, and the search for the edge sees the counts of the whole cloud.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import Run, around, spilling, take, tile_tasks
from lpcompare.types import Indices, Mask, Points
from lpcompare_baselines._calibration import search_size, surface_spacing
from lpcompare_baselines._cells import cell_means


def stages(job: Job, run: Run) -> None:
    """Search the edge that gives the count, with a stage for every probe; keep."""
    spilling(job, run)
    edge = job.settings.get("cell_size")
    if edge is None:
        corners = np.stack([job.load("whole")["low"], job.load("whole")["high"]])
        start = surface_spacing(corners, job.target_count)
        edge = search_size(lambda size: _count(job, run, size), job.target_count, start)
    job.save("edge", edge=edge)
    run("selection", tile_tasks(job, keep, "chosen"))


def summary(job: Job) -> dict[str, Any]:
    """The edge of a cube, in model units."""
    return {"cell_size": float(job.load("edge")["edge"])}


def _count(job: Job, run: Run, edge: float) -> int:
    """Occupied cubes of the whole cloud."""
    name = f"cubes-{edge.hex()}"
    task = partial(count_cubes, name=name, edge=edge)
    run("calibration", tile_tasks(job, task, name))
    return int(job.gather(name, range(job.n_tiles))["count"].sum())


class _Cubes(NamedTuple):
    """Points in and around a tile in input order, their rows, the cube of each, and the cubes of the tile."""

    points: Points
    rows: Indices
    cubes: Indices
    own: Mask


def count_cubes(job: Job, tile: int, *, name: str, edge: float) -> None:
    """Count the cubes that belong to a tile."""
    job.save(name, tile, count=np.count_nonzero(_cubes(job, tile, edge).own))


def _cubes(job: Job, tile: int, edge: float) -> _Cubes:
    low = job.load("whole")["low"]
    near = around(job, tile, 2 * edge)
    points = np.concatenate([job.map_array("points", tile), take(job, "points", near)])
    rows = np.concatenate([job.map_array("rows", tile), take(job, "rows", near)]).astype(np.intp)
    tiles = np.append(np.full(len(points) - len(near.tiles), tile), near.tiles)
    order = np.argsort(rows, kind="stable")
    x, y, z = ((points[order] - low) / edge).astype(np.int64).T
    _, along_y, along_z = ((job.load("whole")["high"] - low) / edge).astype(np.int64) + 1
    cubes = np.unique((x * along_y + y) * along_z + z, return_inverse=True)[1]
    first = np.full(cubes.max(initial=-1) + 1, job.n_tiles)
    np.minimum.at(first, cubes, tiles[order])
    return _Cubes(points[order], rows[order], cubes, first == tile)


def keep(job: Job, tile: int) -> None:
    """Of each cube of a tile, keep the point nearest to the mean of its points."""
    points, rows, cubes, own = _cubes(job, tile, float(job.load("edge")["edge"]))
    kept = rows[:0]
    if len(points):
        means, group = cell_means(points, cubes)
        squared = np.square(points - means[group]).sum(axis=1)
        order = np.lexsort((squared, group))
        nearest = order[np.flatnonzero(np.diff(group[order], prepend=-1))]
        kept = np.sort(rows[nearest[own]])
    job.save_array("kept", tile, kept)
    job.save("chosen", tile, count=len(kept))
