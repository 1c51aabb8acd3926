"""`poisson_disk` of files: a maximal set of points that are a radius apart, tile after tile by color.

The order of the points, which decides, is drawn from the seed within a tile; across tiles it is that of the
colors: a tile sees what the tiles around it of earlier colors kept. The count is near the one asked for, as
MeshLab's is, whose random state cannot be had here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.large.spacing import disk_counts, radius_of, trial_radii
from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import (
    Run,
    around,
    normalized,
    save_turns,
    spilling,
    take,
    tile_tasks,
    tiles_before,
    uniform,
)
from lpcompare.uniform.disks import keep_disks


def stages(job: Job, run: Run) -> None:
    """Count disks at some radii, choose the radius, keep by color."""
    spilling(job, run)
    job.once("radii", _foresee_radii)
    run("counting", tile_tasks(job, count, "disks"))
    job.once("radius", _find_radius)
    save_turns(job, float(job.load("radius")["radius"]))
    run("selection", tile_tasks(job, keep, "chosen", in_turns=True))


def summary(job: Job) -> dict[str, Any]:
    """The radius, in model units."""
    return {"radius": float(job.load("radius")["radius"])}


def _foresee_radii(job: Job) -> None:
    job.save("radii", radii=trial_radii(job))


def _find_radius(job: Job) -> None:
    radius = job.settings.get("radius")
    if radius is None:
        counts = job.sums("disks")["counts"]
        scale = float(job.load("whole")["scale"])
        radius = scale * radius_of(job.target_count, job.load("radii")["radii"], counts)
    job.save("radius", radius=radius)


def count(job: Job, tile: int) -> None:
    """Disks of each radius in a tile."""
    points = normalized(job, job.map_array("points", tile))
    counts = disk_counts(points, job.load("radii")["radii"], 1.0)
    job.save("disks", tile, counts=counts)


def keep(job: Job, tile: int) -> None:
    """Keep the points of a tile that are a radius from all that are kept before."""
    radius = float(job.load("radius")["radius"])
    near = around(job, tile, radius)
    before = np.zeros(len(near.tiles), dtype=bool)
    for other in tiles_before(job, tile):
        some = near.tiles == other
        before[some] = np.isin(near.places[some], job.map_array("kept_places", other))
    fixed = take(job, "points", near)[before]
    own, rows = np.asarray(job.map_array("points", tile)), np.asarray(job.map_array("rows", tile))
    order = np.argsort(uniform(rows, job.seed + 1), kind="stable")
    points = np.concatenate([fixed, own])
    table = np.empty(1 << (4 * len(points) + 2).bit_length(), dtype=np.int32)
    turns = np.append(np.arange(len(fixed)), len(fixed) + order)
    kept = np.sort(keep_disks(points, turns, radius, len(points), table)[len(fixed) :] - len(fixed))
    job.save_array("kept_places", tile, kept)
    job.save_array("kept", tile, rows[kept])
    job.save("chosen", tile, count=len(kept))
