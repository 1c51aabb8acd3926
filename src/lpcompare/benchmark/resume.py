"""What an earlier start in a run's folder finished, and which of it a plan can take over."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import msgspec

import lpcompare
from lpcompare.benchmark.plan import Plan
from lpcompare.benchmark.record import Record, Run, load_run
from lpcompare.benchmark.run_folder import file_name
from lpcompare.errors import InputError
from lpcompare.io.arrays import digest
from lpcompare.registry import METHODS, METRICS
from lpcompare.types import PointCloud

_CONDITIONS = ("metrics", "protocol", "refine", "threads")
"""What is the same for all cases of a run; models, methods, reductions, seeds and repeats may be others."""

_LIMITS = ("time_limit_s", "memory_limit_mib")

_SHARED = (
    "types.py",
    "mesh_library.py",
    "metrics/comparison.py",
    "geometry/*.py",
    "paper/*.py",
    "uniform/*.py",
)


def earlier_run(folder: Path, plan: Plan, models: Mapping[str, PointCloud], *, resume: bool) -> Run | None:
    """The run that the folder holds, if the plan can go on with it.

    Parameters
    ----------
    folder : Path
    plan : Plan
    models : mapping of str to PointCloud
        The clouds of ``plan.models``.
    resume : bool

    Returns
    -------
    Run or None
        None where there is no run.

    Raises
    ------
    InputError
        There is one and ``resume`` is false, or its finished cases were run under other conditions or on
        other clouds.
    """
    if not (folder / "run.json").exists():
        return None
    if not resume:
        raise InputError(f"{folder} already holds a run; continue it with --resume, or name another folder.")
    run = load_run(folder)
    if run.records:
        _check_conditions(run, plan)
        _check_clouds(run, models)
    return run


def reusable(run: Run, plan: Plan) -> dict[str, Record]:
    """Finished records by key; under other limits, not what those limits may have ended."""
    alike = all(run.plan.get(name) == getattr(plan, name) for name in _LIMITS)
    return {r.key: r for r in run.records if r.key and (alike or r.status not in ("failed", "timeout"))}


def case_key(blank: Record, facts: list[Any], metrics: Iterable[str]) -> str:
    """SHA-256 over all that decides the result of a case.

    Parameters
    ----------
    blank : Record
        The case, not yet run.
    facts : list
        What else does: digests of the clouds, conditions of the run, versions of packages.
    metrics : iterable of str
        Their code counts, as the method's does.
    """
    code = [method_digest(blank.method), *(_digest([METRICS.source(name)]) for name in metrics)]
    return _digest([msgspec.json.encode([code, blank, facts], enc_hook=repr, order="deterministic")])


@cache
def method_digest(name: str) -> str:
    """SHA-256 of the method's file, of the helpers beside it and of the steps that methods share."""
    home = METHODS.path(name).parent
    helpers = sorted(home.glob("_*.py"))
    root = Path(lpcompare.__file__).parent
    shared = sorted(path for pattern in _SHARED for path in root.glob(pattern))
    return _digest([METHODS.source(name), *(path.read_bytes() for path in (*helpers, *shared))])


def _digest(parts: Iterable[bytes]) -> str:
    state = hashlib.sha256()
    for part in parts:
        state.update(len(part).to_bytes(8, "big") + part)
    return state.hexdigest()


def _check_conditions(run: Run, plan: Plan) -> None:
    asked = plan.to_dict()
    for name in _CONDITIONS:
        before, now = run.plan.get(name, asked[name]), asked[name]
        if before != now:
            raise InputError(
                f"The cases finished in {run.folder} were run with {name} {_words(before)}, and now "
                f"{_words(now)} is asked for; ask for the same again, or name another folder with --out."
            )


def _check_clouds(run: Run, models: Mapping[str, PointCloud]) -> None:
    for cloud in models.values():
        before = run.inputs.get(file_name(cloud.name))
        if before is not None and before["sha256"] != digest(cloud):
            raise InputError(
                f"The cases finished in {run.folder} were run on another cloud called {cloud.name!r}; "
                "give the same one to continue, or name another folder with --out."
            )


def _words(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
