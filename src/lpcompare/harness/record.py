"""The records of a run, and run.json: one row per case and repeat, with the plan and the environment.

Layout of a run's folder::

    run.json        {"schema_version", "plan", "environment", "records": [Record, ...]}
    records.csv     the same rows, flat: one column per field, per metric and per stage time
    clouds/         <model>.npz (points, faces) and one .npz per result (points, indices, plane_errors)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

SCHEMA_VERSION = 1
STATUSES = ("ok", "skipped", "failed", "timeout")


@dataclass(frozen=True)
class Record:
    """One case, run once.

    Attributes
    ----------
    model, method : str
        Registered names, or a file's stem.
    reduction : float
        Share of the points removed.
    n_input, target_count : int
        Points of the model, points asked for.
    n_output : int or None
        Points returned.
    seed, repeat : int
    status : str
        One of ``STATUSES``.
    message : str
        Why, where the status is not ok.
    settings : mapping
        Effective settings of the method.
    runtime_s, calibration_s : float or None
        Seconds of the call, and of the search for its radius or cell size before it.
    peak_memory_mib : float or None
        Largest resident memory of the child process.
    subset, needs_mesh : bool or None
        Whether the result is a subset of the input, and whether the method was given the mesh.
    timings : mapping of str to float
        Seconds per stage, as the method reports them.
    metrics : mapping of str to float
        One value per metric column.
    cloud : str
        File of the result, relative to the run's folder; empty when it was not kept.
    """

    model: str
    method: str
    reduction: float
    n_input: int
    target_count: int
    seed: int
    repeat: int
    status: str
    message: str = ""
    n_output: int | None = None
    runtime_s: float | None = None
    calibration_s: float | None = None
    peak_memory_mib: float | None = None
    subset: bool | None = None
    needs_mesh: bool | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)
    cloud: str = ""

    def to_dict(self) -> dict[str, Any]:
        """The record as JSON-ready values."""
        return asdict(self)

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Record:
        """The record of a JSON object; keys that this version does not know are left out."""
        known = {f.name for f in fields(cls)}
        return cls(**{key: value for key, value in row.items() if key in known})
