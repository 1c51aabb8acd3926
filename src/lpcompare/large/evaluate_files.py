"""The public function `evaluate_files`: how well a reduced file represents the files that it was made from.

Both clouds are spilled into the same tiles. A tile looks for neighbours in growing boxes around it, until none of
those that it found could be displaced by a point farther out. So the figures are those of the whole clouds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.checks import warn_left_out
from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes, plane_distances
from lpcompare.geometry.scale import bounding_box_center
from lpcompare.io import read
from lpcompare.large.estimate import check_disk, choose_n_tiles
from lpcompare.large.simplify_files import some_client, spill_folder, spilling_folder
from lpcompare.progress import Callback
from lpcompare.tiles.fetch import local_files
from lpcompare.tiles.job import Job
from lpcompare.tiles.streams import count_points
from lpcompare.tiles.tasks import Executor
from lpcompare.tiles.tiles import Run, distances_to_box, reading, spilling, take, tile_tasks, within
from lpcompare.types import Points, Vector

_SIZES = (6, 8, 12)
_NORMAL_NEIGHBORS = 10
_FEW = 64
"""Points that the first box around a tile should hold."""


def evaluate_files(
    original: str | Path | Iterable[str | Path],
    reduced: str | Path,
    *,
    n_tiles: int | None = None,
    memory: int | None = None,
    spill: str | Path | None = None,
    callback: Callback | None = None,
    client: Any = None,
    workers: int = 0,
) -> dict[str, float]:
    """Plane error, distances and normal deviation of clouds larger than memory.

    Parameters
    ----------
    original : path or iterable of path
        As the inputs of `simplify_files`; or files of any format that `read` knows. One that cannot be read in
        parts is read whole, so that it has to fit in memory.
    reduced : path
        The thinned cloud, likewise.
    n_tiles, memory, spill, callback, client, workers
        As in `simplify_files`; the figures do not depend on them.

    Returns
    -------
    dict of str to float
        Columns of `lpcompare.evaluate`, equal to its values but for the rounding of sums. Where neighbours are
        equally far, the choice among them may differ.

    Raises
    ------
    InputError
        A file cannot be read, or the disk has no room.

    Warns
    -----
    PointsLeftOut
        Points of a file have a coordinate that is NaN or infinite, and do not count.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import numpy as np
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> cloud = np.random.default_rng(0).random((2000, 3)) * [10.0, 10.0, 0.0]
    >>> np.save(folder / "ground.npy", cloud)
    >>> np.save(folder / "thin.npy", cloud[::10])
    >>> round(evaluate_files(folder / "ground.npy", folder / "thin.npy")["plane_error_pct"], 9)
    0.0
    """
    folder = spill_folder(Path(reduced), spill, "evaluate")
    with spilling_folder(folder, resume=False):
        jobs = [
            _job(folder / name, files) for name, files in (("original", original), ("reduced", [reduced]))
        ]
        n_points = sum(job.n_points for job in jobs)
        n_workers = len(client.nthreads()) if client is not None else workers
        n_tiles = choose_n_tiles("evaluate", n_points, memory, max(1, n_workers), n_tiles)
        check_disk(folder, "evaluate", n_points)
        whole, few = (replace(job, n_tiles=n_tiles) for job in jobs)
        with some_client(client, workers) as some:
            executor = Executor(some, callback)
            _spill(whole, few, executor)
            executor.run("error", whole, tile_tasks(whole, partial(measure, reduced=few), "figures"))
        for job, where in ((whole, "The original"), (few, "The reduced cloud")):
            warn_left_out(job.n_points - int(job.load("whole")["count"]), job.n_points, where)
        return _figures(whole)


def _job(folder: Path, files: str | Path | Iterable[str | Path]) -> Job:
    paths = local_files(files, folder / "inputs")
    counted = tuple(_in_parts(path, folder / f"whole-{i}.npy") for i, path in enumerate(paths))
    return Job(folder, counted, 1, "evaluate")


def _in_parts(path: Path, copy: Path) -> tuple[Path, int]:
    """A file that can be read in parts and its points; where ``path`` cannot, its coordinates as ``copy``."""
    try:
        return path, count_points(path)
    except InputError:
        points = read(path).points  # says what is wrong where the file is not good at all
        copy.parent.mkdir(parents=True, exist_ok=True)
        np.save(copy, points)
        return copy, len(points)


def _spill(whole: Job, few: Job, executor: Executor) -> None:
    def runs(job: Job) -> Run:
        return lambda stage, tasks: executor.run(stage, job, tasks)

    reading(whole, runs(whole))
    spilling(whole, runs(whole))
    reading(few, runs(few), whole.load("whole")["cuts"])
    spilling(few, runs(few))


def _figures(job: Job) -> dict[str, float]:
    """The columns, from the sums and the largest values of the tiles."""
    parts, whole = job.gather("figures"), job.load("whole")
    n_points = int(whole["count"])
    diagonal = float(np.linalg.norm(whole["high"] - whole["low"]))
    if diagonal == 0:
        raise InputError("The original has no extent, so that no share of its diagonal can be said.")
    sums, largest = parts["sums"].sum(axis=0), parts["largest"].max(axis=0)
    k6, k8, k12, distance, angle = sums / n_points
    percent = 100.0 / diagonal
    values = {
        "plane_error_pct": k8 * percent,
        "plane_error_max_pct": largest[0] * percent,
        "plane_error": k8,
        "plane_error_k6_pct": k6 * percent,
        "plane_error_k12_pct": k12 * percent,
        "mean_distance_pct": distance * percent,
        "hausdorff_pct": max(largest[1], largest[2]) * percent,
        "hausdorff_backward_pct": largest[2] * percent,
        "normal_deviation_deg": angle,
    }
    return {name: float(value) for name, value in values.items()}


def measure(job: Job, tile: int, *, reduced: Job) -> None:
    """Sums and largest values of one tile."""
    boxes, center = job.load("boxes"), bounding_box_center(_corners(job))
    points = np.asarray(job.map_array("points", tile))
    sums, largest = np.zeros(5), np.zeros(3)
    if len(points):
        low, high = boxes["low"][tile], boxes["high"][tile]
        near = _found(reduced, low, high, lambda few: _reach(few, points, low, high))
        originals = _found(job, low, high, lambda some: _own_reach(some, points, _NORMAL_NEIGHBORS))
        sums, largest[:2] = _compare(points - center, originals - center, near - center)
    back = np.asarray(reduced.map_array("points", tile))
    if len(back):
        low, high = back.min(axis=0), back.max(axis=0)
        originals = _found(job, low, high, lambda some: _own_reach(some, back, 1))
        largest[2] = Neighbors(originals).query(back, 1)[0].max()
    job.save("figures", tile, sums=sums, largest=largest)


def _corners(job: Job) -> Points:
    return np.stack([job.load("whole")["low"], job.load("whole")["high"]])


def _compare(points: Points, originals: Points, near: Points) -> tuple[Vector, Vector]:
    """Sums over the points of a tile, and the largest plane error and distance."""
    tree = Neighbors(near)
    distances, indices = tree.query(points, max(_SIZES))
    errors = [plane_distances(points, near, indices[:, :k]) for k in _SIZES]
    known = Neighbors(originals).query(points, _NORMAL_NEIGHBORS)[1]
    normals = fit_planes(originals, known)[1]
    used, which = np.unique(indices[:, 0], return_inverse=True)
    beside = fit_planes(near, tree.query(near[used], _NORMAL_NEIGHBORS)[1])[1][which]
    cross = np.linalg.norm(np.cross(normals, beside), axis=1)
    angles = np.degrees(np.arctan2(cross, np.abs(np.einsum("qi,qi->q", normals, beside))))
    values = [*errors, distances[:, 0], angles]
    return np.array([v.sum() for v in values]), np.array([errors[1].max(), distances[:, 0].max()])


def _found(job: Job, low: Vector, high: Vector, needed: Callable[[Points], float]) -> Points:
    """The points of a cloud around a box, as far out as ``needed`` says of those found; all if need be."""
    extent = float(np.linalg.norm(high - low)) or 1.0
    reach, n_points = 0.05 * extent, int(job.load("whole")["count"])
    while True:
        near = within(job, low, high, reach)
        points: NDArray[np.float64] = np.array(take(job, "points", near))
        if len(points) == n_points:
            return points
        wanted = needed(points) if len(points) >= min(_FEW, n_points) else 2 * reach
        if wanted <= reach:
            return points
        reach = min(wanted, 4 * reach) * (1 + 1e-9)


def _own_reach(points: Points, queries: Points, n_neighbors: int) -> float:
    """How far from their box the nearest points of some queries may lie."""
    return float(Neighbors(points).query(queries, n_neighbors)[0][:, -1].max())


def _reach(near: Points, queries: Points, low: Vector, high: Vector) -> float:
    """The same for planes, and for the normals at the reduced points that are nearest."""
    tree = Neighbors(near)
    distances, indices = tree.query(queries, max(_SIZES))
    used = near[np.unique(indices[:, 0])]
    around = tree.query(used, _NORMAL_NEIGHBORS)[0][:, -1] + distances_to_box(used, low, high)
    return float(max(distances[:, -1].max(), around.max()))
