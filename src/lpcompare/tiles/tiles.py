"""Tiles: the cut of a sample of all files, the points of each tile on disk, and what lies around a tile."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpcompare.checks import check_magnitude, valid_rows
from lpcompare.errors import InputError
from lpcompare.geometry.scale import normalize
from lpcompare.tiles.colors import coloring, earlier
from lpcompare.tiles.job import Arrays, Block, Job
from lpcompare.tiles.streams import read_rows
from lpcompare.tiles.tasks import Task
from lpcompare.types import Indices, Points, Vector

SAMPLE = 250_000
"""Points of the sample, about; the tiles and the mixture come from it."""

Run = Callable[[str, list[Task]], None]
"""Runs the tasks of a stage, which has a name."""
_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB), np.uint64(0x9E3779B97F4A7C15))


def survey(job: Job, number: int) -> None:
    """Count, box and sample of one block."""
    block = job.blocks[number]
    points, rows = valid_points(job, block)
    share = SAMPLE / job.n_points
    low, high = (f(points, axis=0, initial=v) for f, v in ((np.min, np.inf), (np.max, -np.inf)))
    drawn = points[uniform(rows, job.seed) < share]
    job.save("survey", number, count=len(points), low=low, high=high, sample=drawn)


def uniform(rows: Indices, seed: int) -> Vector:
    """A number from 0 to 1 for every row of the input, which nothing but the seed decides (SplitMix64)."""
    with np.errstate(over="ignore"):
        state = (rows.astype(np.uint64) + np.uint64(1)) * _MIX[2] + np.uint64(seed) * _MIX[1]
        state = (state ^ (state >> np.uint64(30))) * _MIX[0]
        state = (state ^ (state >> np.uint64(27))) * _MIX[1]
    return ((state ^ (state >> np.uint64(31))) >> np.uint64(11)).astype(np.float64) * 2.0**-53


def whole(job: Job, cuts: NDArray[np.float64] | None) -> None:
    """Count, box, centre, scale and sample of the whole cloud, and the cut into tiles, from the surveys."""
    parts = [job.load("survey", block.number) for block in job.blocks]
    n_points = sum(int(part["count"]) for part in parts)
    low, high = (
        np.min([part["low"] for part in parts], axis=0),
        np.max([part["high"] for part in parts], axis=0),
    )
    if not n_points:
        raise InputError(f"{_names(job)}: no point has three finite coordinates; give at least one.")
    check_magnitude(low, high, _names(job))
    if job.target_count > n_points:
        raise InputError(
            f"target_count is {job.target_count}; "
            f"it must be from 1 to the {n_points} points that have coordinates."
        )
    sample = np.concatenate([part["sample"] for part in parts])
    _, center, scale = normalize(sample)
    job.save("sample", points=sample)
    job.save(
        "whole",
        count=n_points,
        low=low,
        high=high,
        center=center,
        scale=scale,
        cuts=cut(sample, job.n_tiles) if cuts is None else cuts,
    )


def _names(job: Job) -> str:
    """The inputs by name, the first of many."""
    first, more = job.inputs[0][0].name, len(job.inputs) - 1
    return f"{first} and {more} more files" if more else first


def cut(sample: Points, n_tiles: int) -> NDArray[np.float64]:
    """A k-d tree whose leaves hold about equally many points of a sample.

    Parameters
    ----------
    sample : ndarray, shape (s, 3)
    n_tiles : int

    Returns
    -------
    ndarray, shape (n_tiles - 1, 4)
        Axis and place of each cut, and the two children: cuts, or leaves as -1 - tile.
    """
    cuts = np.zeros((n_tiles - 1, 4))
    made = iter(range(n_tiles - 1))

    def halve(points: Points, first: int, n: int) -> int:
        if n == 1:
            return -1 - first
        node, left = next(made), n // 2
        axis = int(np.ptp(points, axis=0).argmax()) if len(points) else 0
        ordered = np.sort(points[:, axis])
        place = float(ordered[len(ordered) * left // n]) if len(points) else 0.0
        lower = points[:, axis] < place
        children = halve(points[lower], first, left), halve(points[~lower], first + left, n - left)
        cuts[node] = axis, place, *children
        return node

    halve(sample, 0, n_tiles)
    return cuts


def tile_of(points: Points, cuts: NDArray[np.float64]) -> Indices:
    """The tile of every point, shape (n,)."""
    tiles = np.zeros(len(points), dtype=np.intp)
    pending = [(0, np.arange(len(points)))] if len(cuts) else []
    while pending:
        node, rows = pending.pop()
        if node < 0:
            tiles[rows] = -1 - node
            continue
        axis, place, left, right = cuts[node]
        lower = points[rows, int(axis)] < place
        pending += [(int(left), rows[lower]), (int(right), rows[~lower])]
    return tiles


def bounds_of(whole: Arrays, tile: int, beyond: float) -> tuple[Vector, Vector]:
    """Low and high corner of the part of space that a tile is; without a cut, so far beyond the cloud."""
    low, high, cuts = whole["low"] - beyond, whole["high"] + beyond, whole["cuts"]
    child = -1 - tile
    for node in range(len(cuts) - 1, -1, -1):  # children come after their cut
        axis, place, left, right = cuts[node]
        if child in (left, right):
            end, tighter = (high, np.minimum) if child == left else (low, np.maximum)
            end[int(axis)] = tighter(end[int(axis)], place)
            child = node
    return low, high


def spill(job: Job, number: int) -> None:
    """Write the points and rows of one block, sorted by tile."""
    points, rows = valid_points(job, job.blocks[number])
    tiles = tile_of(points, job.load("whole")["cuts"])
    order = np.argsort(tiles, kind="stable")
    starts = np.searchsorted(tiles[order], np.arange(job.n_tiles + 1))
    job.save_array("block_points", number, points[order])
    job.save_array("block_rows", number, rows[order])
    job.save("block_starts", number, starts=starts)


def collect(job: Job, number: int) -> None:
    """Put the points of one tile together, in input order."""
    points, rows = list[Points](), list[Indices]()
    for block in job.blocks:
        some = slice(*job.load("block_starts", block.number)["starts"][number : number + 2])
        points.append(job.map_array("block_points", block.number)[some])
        rows.append(job.map_array("block_rows", block.number)[some])
    every = np.concatenate(points)
    job.save_array("points", number, every)
    job.save_array("rows", number, np.concatenate(rows))
    edges = (
        (every.min(axis=0), every.max(axis=0)) if len(every) else (np.full(3, np.inf), np.full(3, -np.inf))
    )
    job.save("box", number, count=len(every), low=edges[0], high=edges[1])


def block_tasks(job: Job, function: Callable[[Job, int], None], name: str) -> list[Task]:
    """One task for every block, which leaves the result ``name``."""
    return [Task(function, block.number, job.path(name, block.number)) for block in job.blocks]


def tile_tasks(
    job: Job,
    function: Callable[[Job, int], None],
    name: str,
    *,
    in_turns: bool = False,
) -> list[Task]:
    """One task for every tile, which leaves the result ``name``; in turns, after those of `tiles_before`."""
    before = [tiles_before(job, tile) if in_turns else () for tile in range(job.n_tiles)]
    return [
        Task(function, tile, job.path(name, tile), tuple(job.path(name, int(t)) for t in before[tile]))
        for tile in range(job.n_tiles)
    ]


def reading(job: Job, run: Run, cuts: NDArray[np.float64] | None = None) -> None:
    """The stage after which the sample and the cut, unless it is given, are known."""
    run("reading", block_tasks(job, survey, "survey"))
    job.once("whole", partial(whole, cuts=cuts))


def spilling(job: Job, run: Run) -> None:
    """The stages after which every tile is on disk."""
    if not job.path("boxes").exists():
        run("spilling", block_tasks(job, spill, "block_starts"))
        run("sorting", tile_tasks(job, collect, "box"))
        job.save("boxes", **job.gather("box"))
    for block in job.blocks:
        job.path("block_points", block.number, ".npy").unlink(missing_ok=True)
        job.path("block_rows", block.number, ".npy").unlink(missing_ok=True)


def normalized(job: Job, points: Points) -> Points:
    """Coordinates about the centre of the sample, in units of its mean radius."""
    whole = job.load("whole")
    return (np.asarray(points) - whole["center"]) / whole["scale"]


class Around(NamedTuple):
    """Points of other tiles near a tile: their tiles, and their places in these."""

    tiles: Indices
    places: Indices


def distances_to_box(points: Points, low: Vector, high: Vector) -> Vector:
    """Distance of every point to a box, 0 inside, shape (n,)."""
    return np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)


def _apart(boxes: Arrays, low: Vector, high: Vector) -> Vector:
    """Distance of every tile's box to a box, infinity for tiles without points, shape (t,)."""
    gaps = np.maximum(np.maximum(low - boxes["high"], boxes["low"] - high), 0.0)
    return np.where(boxes["count"] > 0, np.linalg.norm(gaps, axis=1), np.inf)


def save_turns(job: Job, reach: float) -> None:
    """Colors of the tiles that are within a reach of each other, and whom each one waits for."""
    boxes = job.load("boxes")
    apart = (_apart(boxes, low, high) for low, high in zip(boxes["low"], boxes["high"], strict=True))
    touching = [np.setdiff1d(np.flatnonzero(far <= reach), tile) for tile, far in enumerate(apart)]
    colors = coloring(touching)
    before = earlier(touching, colors)
    starts = np.append(0, np.cumsum([len(others) for others in before]))
    job.save("turns", colors=colors, starts=starts, before=np.concatenate(before))


def tiles_before(job: Job, tile: int) -> Indices:
    """The tiles that a tile waits for."""
    turns = job.load("turns")
    return turns["before"][slice(*turns["starts"][tile : tile + 2])]


def around(job: Job, tile: int, reach: float) -> Around:
    """The points of other tiles that are within a reach, in model units, of a tile's box."""
    boxes = job.load("boxes")
    return within(job, boxes["low"][tile], boxes["high"][tile], reach, without=tile)


def within(job: Job, low: Vector, high: Vector, reach: float, without: int = -1) -> Around:
    """The points of all tiles, but one, that are within a reach of a box."""
    apart = _apart(job.load("boxes"), low, high)
    tiles, places = [np.empty(0, dtype=np.intp)], [np.empty(0, dtype=np.intp)]
    for tile in np.flatnonzero(apart <= reach).tolist():
        if tile != without:
            near = distances_to_box(job.map_array("points", tile), low, high) <= reach
            places.append(np.flatnonzero(near))
            tiles.append(np.full(len(places[-1]), tile, dtype=np.intp))
    return Around(np.concatenate(tiles), np.concatenate(places))


def take(job: Job, name: str, near: Around) -> NDArray[np.float64]:
    """The values of an array of the tiles at the points around a tile."""
    tiles = np.unique(near.tiles)
    parts = [job.map_array(name, tile)[near.places[near.tiles == tile]] for tile in tiles]
    return np.concatenate(parts) if parts else job.map_array(name, 0)[:0]


def valid_points(job: Job, block: Block) -> tuple[Points, Indices]:
    """The points of a block that have coordinates, and their rows in the input."""
    points, _ = read_rows(block.path, block.start, block.stop)
    valid = np.flatnonzero(valid_rows(points))
    return points[valid], valid + block.before
