"""The public function `simplify_files`: clouds larger than memory, on one machine or many."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from lpcompare.checks import check_integer, check_target
from lpcompare.errors import InputError, SolverError
from lpcompare.files import check_unchanged, replace_text, state_of, writing
from lpcompare.io import check_target as check_output
from lpcompare.io import same_format
from lpcompare.large.estimate import check_disk, choose_n_tiles, used_mib
from lpcompare.progress import Callback, StageClock
from lpcompare.registry import METHODS, call
from lpcompare.tiles.fetch import local_files
from lpcompare.tiles.job import Job
from lpcompare.tiles.output import write_kept
from lpcompare.tiles.streams import count_points
from lpcompare.tiles.tasks import Executor, Task
from lpcompare.tiles.tiles import reading
from lpcompare.types import PointCloud

_LONGEST_NAME = 255
"""Bytes of a file's name that file systems take."""

_LOCK, _ORDER = "spill.lock", "job.json"

TILED = {
    "lp_density": "tiled_density",
    "lp_printed": "tiled_density",
    "lp_uniform": "tiled_uniform",
    "poisson_disk": "tiled_disks",
    "random_sample": "tiled_random",
    "voxel_nearest": "tiled_voxels",
}
"""Methods with the trait ``in_tiles``, and the files of this folder that say how."""


@dataclass(frozen=True)
class FilesResult:
    """What `simplify_files` did.

    Attributes
    ----------
    n_points, n_kept : int
        Points of the input that have coordinates, and points written.
    outputs : tuple of Path
    n_tiles : int
    spill_mib : float
        Size of the spill folder at the end.
    timings : mapping of str to float
        Seconds per stage.
    info : mapping of str to Any
        What the method says, such as the densities of the clusters; ``cuts``, shape (n_tiles - 1, 4), is the
        k-d tree of the tiles: axis, place, and two children, which are cuts or leaves as -1 - tile.
    notes : tuple of str
        What the output lacks.
    """

    n_points: int
    n_kept: int
    outputs: tuple[Path, ...]
    n_tiles: int
    spill_mib: float
    timings: Mapping[str, float]
    info: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def simplify_files(
    inputs: str | Path | Iterable[str | Path],
    output: str | Path,
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    method: str = "lp_uniform",
    n_tiles: int | None = None,
    memory: int | None = None,
    spill: str | Path | None = None,
    resume: bool = False,
    random_state: int = 0,
    callback: Callback | None = None,
    client: Any = None,
    workers: int = 0,
    **settings: Any,
) -> FilesResult:
    """Thin files of any size together, and write what is kept in input order with all that the files say of it.

    Parameters
    ----------
    inputs : path or iterable of path
        LAS, LAZ, COPC, binary PLY, binary PCD or NPY, all of one format; URLs are fetched once (fsspec).
    output : path
        A file of the format of the inputs, or a folder that exists: then each input has a file in it.
    target_reduction, target_count : float, int
        Share removed or points kept of all files together; exactly one of the two.
    method : str
        One that works in tiles: see `TILED`.
    n_tiles : int, optional
        By default as many as the memory asks for. The result depends on it.
    memory : int, optional
        Bytes that all processes may use together; by default half of what is free.
    spill : path, optional
        Folder for the tiles, by default beside the output; it is removed at the end and kept after a failure.
    resume : bool
        Continue from the tasks that are finished in the spill folder.
    random_state : int
        Seed of every random draw. Neither workers nor the order of tasks change the result.
    callback : callable, optional
        Called with (stage, done, total).
    client : distributed.Client, optional
        A client of a running Dask cluster, whose workers see the files and the spill folder under these paths.
    workers : int, optional
        Processes of a Dask cluster on this machine; 0 works in this process, without Dask.
    **settings
        Settings of the method.

    Returns
    -------
    FilesResult

    Raises
    ------
    InputError
        A file, a setting or the count cannot be worked on, the method does not work in tiles, or the disk is
        full; then the spill folder is kept and the text names it.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import numpy as np
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> np.save(folder / "scan.npy", np.random.default_rng(0).normal(size=(4000, 3)))
    >>> simplify_files(folder / "scan.npy", folder / "thin.npy", target_count=400, method="random_sample").n_kept
    400
    """
    settings = _settings(method, settings)
    output, n_workers = Path(output), len(client.nthreads()) if client is not None else workers
    folder = spill_folder(output, spill)
    with spilling_folder(folder, resume=resume):
        files = local_files(inputs, folder / "inputs")
        counts = [count_points(path) for path in files]
        count = check_target(sum(counts), target_reduction, target_count)
        _check_output(files, output)
        n_tiles = choose_n_tiles(method, sum(counts), memory, max(1, n_workers), n_tiles)
        check_disk(folder, method, sum(counts))
        job = Job(
            folder=folder,
            inputs=tuple(zip(files, counts, strict=True)),
            target_count=count,
            method=method,
            settings=settings,
            n_tiles=check_integer("n_tiles", n_tiles, 1, max(count, 1)),
            seed=check_integer("random_state", random_state, 0),
        )
        _claim(job, resume=resume)
        with some_client(client, workers) as some:
            return _run(job, output, Executor(some, callback))


def _run(job: Job, output: Path, executor: Executor) -> FilesResult:
    clock = StageClock(None)
    module = import_module(f"lpcompare.large.{TILED[job.method]}")

    def run(stage: str, tasks: list[Task]) -> None:
        if stage not in executor.n_run:
            clock.stage(stage)
        executor.run(stage, job, tasks)

    reading(job, run)
    module.stages(job, run)
    clock.stage("writing")
    n_kept, outputs, notes = write_kept(job, output, executor.callback, lambda: _check_inputs(job))
    info = module.summary(job) if hasattr(module, "summary") else {}
    info["cuts"] = job.load("whole")["cuts"]
    n_points = int(job.load("whole")["count"])
    if n_points < job.n_points:
        notes = (f"{job.n_points - n_points:,} points without coordinates were left out", *notes)
    return FilesResult(
        n_points, n_kept, outputs, job.n_tiles, used_mib(job.folder), clock.stop(), info, notes
    )


def _settings(method: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Every setting of the method, or the reason why it cannot work on files."""
    traits = METHODS.traits(method)
    if not traits.in_tiles:
        why = "needs the mesh" if traits.needs_mesh else "looks at the whole cloud at once"
        raise InputError(f"{method} {why}, so it does not work in tiles; choose one of {', '.join(TILED)}.")
    METHODS.check_settings(method, settings)
    every = METHODS.settings(method) | dict(settings)
    if every.get("density", "mean") != "mean":
        raise InputError(f"{method}.density is {every['density']!r}; in tiles only 'mean' can be used.")
    if hasattr(METHODS.module(method), "THINNING"):
        call(method, PointCloud(np.eye(3)), 2, settings=settings)  # a few points show a setting out of range
    return {name: value for name, value in every.items() if name in settings or value is not None}


def _check_output(files: list[Path], output: Path) -> None:
    """The output can be written, in the format of the inputs, and replaces none of them."""
    for path in files:
        target = output / path.name if output.is_dir() else output
        check_output(target)
        if not same_format(path, target):
            raise InputError(
                f"{path.name} and {target.name} are not of one format; files in tiles are written as they were read."
            )
        if target.exists() and target.samefile(path):
            raise InputError(f"{target} is an input and would be replaced; name another file.")
    if output.is_dir() and len({path.name for path in files}) < len(files):
        raise InputError(f"Two inputs have the same name and would share a file in {output}; rename one.")


def spill_folder(output: Path, spill: str | Path | None, work: str = "spill") -> Path:
    """Where the tiles go: the folder that is named, or a hidden one beside the output, which names the ``work``."""
    if spill is not None:
        return Path(spill).absolute()
    if output.is_dir():
        return output.absolute() / f".{work}"
    name = f".{output.name}.{work}"
    if len(os.fsencode(name)) > _LONGEST_NAME:
        name = f".{hashlib.sha256(os.fsencode(name)).hexdigest()}.{work}"
    return output.absolute().with_name(name)


@contextmanager
def spilling_folder(folder: Path, *, resume: bool) -> Iterator[None]:
    """The folder, empty at the start unless it is resumed; after a failure it stays and is named.

    One process works in it at a time. The file of its lock says that it is a spill folder.
    """
    if folder.exists() and any(folder.iterdir()) and not (folder / _LOCK).exists():
        raise InputError(f"{folder} is not empty and no spill folder; name another one with --spill.")
    with _sole_worker(folder), _many_open_files():
        if not resume:
            _empty(folder)
        try:
            yield
        except (KeyboardInterrupt, OSError, InputError, SolverError) as error:
            if not (folder / _ORDER).exists():
                shutil.rmtree(folder)
                raise
            if isinstance(error, OSError):
                raise InputError(f"{error.strerror or error}. {_continue(folder)}") from error
            raise type(error)(f"{error} {_continue(folder)}".strip()) from error
        shutil.rmtree(folder)


@contextmanager
def _sole_worker(folder: Path) -> Iterator[None]:
    """Keep other processes out of the folder, which is made if need be."""
    from filelock import FileLock, Timeout

    lock = FileLock(folder / _LOCK, blocking=False)
    with writing(folder, "make room, or name another folder with --spill"):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            lock.acquire()
        except Timeout as error:
            raise InputError(
                f"Another lpcompare works in {folder}; wait until it has ended, "
                "or name another folder with --spill."
            ) from error
    try:
        yield
    finally:
        lock.release()


@contextmanager
def _many_open_files() -> Iterator[None]:
    """Let this process open as many files as its hard limit allows: a block may have one that stays open."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with suppress(ValueError, OSError):  # a hard limit that the system itself does not allow
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def _empty(folder: Path) -> None:
    """Remove what an earlier start left, but not the lock."""
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.name != _LOCK:
            path.unlink()


def _continue(folder: Path) -> str:
    return f"The finished tiles are in {folder}; continue with --resume."


def _claim(job: Job, *, resume: bool) -> None:
    """Say in the folder what it is for; a folder of another order is not continued."""
    order = {
        "inputs": [[str(path), *state_of(path)] for path, _ in job.inputs],
        "method": [job.method, job.settings, job.target_count, job.n_tiles, job.seed, job.block_rows],
    }
    text = json.dumps(order, sort_keys=True, default=repr)
    mark = hashlib.sha256(text.encode()).hexdigest()
    place = job.folder / _ORDER
    if resume and place.exists():
        if json.loads(place.read_text())["mark"] != mark:
            raise InputError(
                f"{job.folder} belongs to other inputs or settings; repeat the same command, or leave --resume out."
            )
        return
    replace_text(place, json.dumps({"mark": mark, **order}, default=repr))


def _check_inputs(job: Job) -> None:
    """Raise an `InputError` where an input is not as it was at the start."""
    begun = json.loads((job.folder / _ORDER).read_text())
    for (path, _), (_, *state) in zip(job.inputs, begun["inputs"], strict=True):
        check_unchanged(path, (*state,))


@contextmanager
def some_client(client: Any, workers: int) -> Iterator[Any]:
    """The client given, one of a new cluster on this machine, or None."""
    if client is not None or not workers:
        yield client
        return
    from lpcompare.large.cluster import local_client

    with local_client(check_integer("workers", workers, 1)) as some:
        yield some
