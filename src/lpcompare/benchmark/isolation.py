"""A method called in a child process, with limits: what `registry.call` does, one process away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lpcompare.benchmark.case import Request, run_case
from lpcompare.benchmark.environment import physical_memory_mib
from lpcompare.benchmark.record import Record
from lpcompare.errors import InputError, MethodError, NotApplicable
from lpcompare.files import ANOTHER_TMPDIR
from lpcompare.io.arrays import digest, load_arrays, save_cloud
from lpcompare.processes.children import Children, temporary_folder
from lpcompare.registry import Seed
from lpcompare.threads import thread_count
from lpcompare.types import PointCloud, Simplification

_MARKS = ("points", "indices", "plane_errors")


@dataclass(frozen=True)
class Limits:
    """What a child process may use.

    Attributes
    ----------
    time_s : float
        Seconds until it is ended.
    memory_mib : int or None
        Resident memory; by default three quarters of the machine's.
    """

    time_s: float = 3600.0
    memory_mib: int | None = None


def call_isolated(
    name: str,
    cloud: PointCloud,
    target_count: int,
    *,
    random_state: Seed,
    settings: Mapping[str, Any],
    limits: Limits,
) -> Simplification:
    """Call a method in a child process.

    Parameters
    ----------
    name, cloud, target_count, random_state, settings
        Those of `lpcompare.registry.call`.
    limits : Limits

    Returns
    -------
    Simplification
        As `lpcompare.registry.call` returns it; ``info`` has what can be written to a file.

    Raises
    ------
    NotApplicable
        The method declines the input.
    MethodError
        The method failed, crashed, or reached a limit.
    """
    with temporary_folder() as folder:
        save_cloud(folder / "input.npz", cloud, ANOTHER_TMPDIR)
        request = Request(
            record=_asked(name, cloud, target_count),
            input=str(folder / "input.npz"),
            input_sha256=digest(cloud),
            output=str(folder / "output.npz"),
            settings=dict(settings),
            entropy=_entropy(random_state),
        )
        (folder / "case").mkdir()
        record = run_case(
            Children(),
            request,
            folder / "case",
            time_limit_s=limits.time_s,
            memory_limit_mib=limits.memory_mib or physical_memory_mib() * 3 // 4,
            threads=thread_count(),
        ).record
        if record.status == "skipped":
            raise NotApplicable(record.message)
        if record.status != "ok":
            raise MethodError(f"{name} on {cloud.name or 'the cloud'}, {record.status}: {record.message}")
        arrays = load_arrays(folder / "output.npz")
    return Simplification(
        arrays["points"],
        arrays.get("indices"),
        timings={stage: s for stage, s in record.timings.items() if s is not None},
        info={**record.info} | {key: value for key, value in arrays.items() if key not in _MARKS},
        method=name,
        settings=record.settings,
        runtime_s=record.runtime_s,
        calibration_s=record.calibration_s,
        note=record.message,
    )


def _asked(name: str, cloud: PointCloud, target_count: int) -> Record:
    """The record of the call before it is made."""
    return Record(
        model=cloud.name or "cloud",
        method=name,
        reduction=0.0,
        n_input=len(cloud),
        target_count=target_count,
        seed=0,
        repeat=0,
        status="failed",
    )


def _entropy(random_state: Seed) -> int | list[int]:
    """The entropy that gives the child the generator of ``random_state``."""
    if isinstance(random_state, np.random.SeedSequence):
        entropy = random_state.entropy
        if random_state.spawn_key or entropy is None:
            raise InputError("A spawned SeedSequence cannot be handed to a child process; give an integer.")
        return [int(e) for e in entropy] if isinstance(entropy, (list, tuple)) else int(entropy)  # type: ignore[arg-type]
    if isinstance(random_state, np.random.Generator):
        return int(random_state.integers(2**63))
    return int(np.random.default_rng().integers(2**63)) if random_state is None else int(random_state)
