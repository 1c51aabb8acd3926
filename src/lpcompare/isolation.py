"""A method called in a child process, with limits: what `registry.call` does, one process away."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lpcompare.benchmark.case import Children
from lpcompare.benchmark.environment import physical_memory_mib
from lpcompare.errors import InputError, MethodError, NotApplicable
from lpcompare.io.arrays import load_arrays, save_cloud
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
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as name_of_folder:
        folder = Path(name_of_folder).resolve()
        save_cloud(folder / "input.npz", cloud)
        request = {
            "method": name,
            "settings": dict(settings),
            "target_count": target_count,
            "entropy": _entropy(random_state),
            "input": str(folder / "input.npz"),
            "clean": str(folder / "input.npz"),
            "output": str(folder / "output.npz"),
            "metrics": [],
            "parent": os.getpid(),
            "refine": False,
            "time_limit_s": limits.time_s,
            "memory_limit_mib": limits.memory_mib or physical_memory_mib() * 3 // 4,
            "threads": thread_count(),
        }
        (folder / "case").mkdir()
        reply = Children().run(request, folder / "case")
        if reply["status"] == "skipped":
            raise NotApplicable(reply["message"])
        if reply["status"] != "ok":
            raise MethodError(f"{name} on {cloud.name or 'the cloud'}, {reply['status']}: {reply['message']}")
        arrays = load_arrays(folder / "output.npz")
    return Simplification(
        arrays["points"],
        arrays.get("indices"),
        timings=reply["timings"],
        info=reply["info"] | {key: value for key, value in arrays.items() if key not in _MARKS},
        method=name,
        settings=reply["settings"],
        runtime_s=reply["runtime_s"],
        calibration_s=reply["calibration_s"],
        note=reply["message"],
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
