"""The records of a run: one row per case and repeat. The file format is described in docs/run-json.md.

Layout of a run's folder::

    run.json        {"schema_version", "complete", "plan", "environment", "inputs", "records": [Record, ...]}
    records.jsonl   while the run is going on: one finished record per line, ahead of run.json
    records.csv     the same rows, flat: one column per field, per metric and per stage time
    summary.csv     medians, quartiles and bootstrap intervals over repeats and seeds
    clouds/         <input>.npz (points, faces) and one .npz per result (points, indices, plane_errors)
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from lpcompare.benchmark.hints import fits, spell
from lpcompare.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

SCHEMA_VERSION = 1
STATUSES = ("ok", "skipped", "failed", "timeout")


@dataclass(frozen=True)
class Record:
    """One case, run once.

    Attributes
    ----------
    model, method : str
        Registered names, or a file's stem.
    variant : str
        The method with the settings that were chosen, for example ``lp_density n_clusters=25``.
    reduction : float
        Share of the points removed.
    n_input, target_count : int
        Points of the input, points asked for.
    n_output : int or None
        Points returned.
    seed, repeat : int
    status : str
        One of ``STATUSES``.
    message : str
        Why, where the status is not ok.
    perturbation, perturbation_level : str, float
        What was done to the input; ``none`` for the clean cloud.
    refined : bool
        Whether `lpcompare.uniform` worked on the result.
    settings : mapping
        Effective settings of the method, calibrated ones among them.
    runtime_s, cpu_s : float or None
        Seconds of the call on the wall clock, and of all processors together.
    calibration_s : float or None
        Seconds of the search for a radius or a cell size before the call.
    reference_s, reference_cpu_s : float or None
        Seconds of a fixed piece of work in the same process just before and after the call: how fast the
        machine was.
    foreign_load : float or None
        Processors that other programs held on average, from the start of the child process to the end of the
        call.
    peak_memory_mib : float or None
        Largest resident memory of the child process up to the end of the call, imports included.
    subset, needs_mesh : bool or None
        Whether the result is a subset of the input, and whether the method was given the mesh.
    timings : mapping of str to float
        Seconds per stage, as the method reports them.
    metrics : mapping of str to float
        One value per metric column; NaN where a metric is not defined.
    info : mapping of str to number, text or truth value
        What else the method had to say.
    points_sha256 : str
        Digest of the points returned.
    key : str
        Digest of everything that decides the result; equal keys are not computed twice.
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
    variant: str = ""
    perturbation: str = "none"
    perturbation_level: float = 0.0
    refined: bool = False
    n_output: int | None = None
    runtime_s: float | None = None
    calibration_s: float | None = None
    cpu_s: float | None = None
    reference_s: float | None = None
    reference_cpu_s: float | None = None
    foreign_load: float | None = None
    peak_memory_mib: float | None = None
    subset: bool | None = None
    needs_mesh: bool | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)
    info: Mapping[str, Any] = field(default_factory=dict)
    points_sha256: str = ""
    key: str = ""
    cloud: str = ""

    @property
    def case_id(self) -> tuple[object, ...]:
        """Which case of a plan this is the record of, however it was run."""
        damage = (self.perturbation, self.perturbation_level)
        return (self.model, damage, self.variant, self.reduction, self.seed, self.repeat)

    def to_dict(self) -> dict[str, Any]:
        """The record as JSON-ready values; NaN becomes null."""
        row = asdict(self)
        row["metrics"] = {k: v if math.isfinite(v) else None for k, v in self.metrics.items()}
        return row

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Record:
        """The record of a JSON object; keys that this version does not know are left out.

        Raises
        ------
        InputError
            A field is missing or has the wrong type.
        """
        if not isinstance(row, Mapping):
            raise InputError(f"A record is {row!r}, not an object.")
        hints = get_type_hints(cls)
        known = {f.name for f in fields(cls)}
        for name in ("model", "method", "reduction", "n_input", "target_count", "seed", "repeat", "status"):
            if name not in row:
                raise InputError(f"A record has no field {name!r}.")
        chosen = {key: value for key, value in row.items() if key in known}
        for name, value in chosen.items():
            if not fits(value, hints[name]):
                raise InputError(f"A record's {name!r} is {value!r}; it must be {spell(hints[name])}.")
        if row["status"] not in STATUSES:
            raise InputError(
                f"A record's status is {row['status']!r}; it must be one of {', '.join(STATUSES)}."
            )
        metrics = {k: math.nan if v is None else float(v) for k, v in row.get("metrics", {}).items()}
        variant = row.get("variant") or row["method"]
        return cls(**{**chosen, "metrics": metrics, "variant": variant})


@dataclass(frozen=True)
class Run:
    """A run as it stands in its folder.

    Attributes
    ----------
    folder : Path
    plan : mapping
        The fields of `lpcompare.benchmark.plan.Plan`.
    environment : mapping
        Machine, versions, threads, command line.
    inputs : mapping of str to mapping
        Per input: its file below ``folder``, number of points, SHA-256, model and perturbation.
    records : tuple of Record
        In the order of the plan.
    complete : bool
        False while the run is going on, and for good when it was killed or stopped.
    """

    folder: Path
    plan: Mapping[str, Any]
    environment: Mapping[str, Any]
    inputs: Mapping[str, Mapping[str, Any]]
    records: tuple[Record, ...]
    complete: bool

    @cached_property
    def frame(self) -> DataFrame:
        """One row per case and repeat, in the order of the plan. Do not change it in place: it is kept.

        Its columns are the fields of `Record` (NaN or NA where a field is None; ``settings`` and ``info``
        are dicts), but for ``timings`` and ``metrics``: they become ``time_<stage>_s`` and one column per
        metric column, NaN where a case has no value. Two columns are derived:

        ``input``
            The model, with what was done to it: ``bunny`` or ``bunny + noise 0.5``.
        ``label``
            The variant, with " + swaps" where its result was refined.
        """
        import pandas as pd

        rows = [_flat(record) for record in self.records]
        columns = [*_COLUMN_TYPES, *dict.fromkeys(k for row in rows for k in row if k not in _COLUMN_TYPES)]
        return pd.DataFrame(rows, columns=columns).astype(_COLUMN_TYPES)


_COLUMN_TYPES = {
    "model": "str",
    "perturbation": "str",
    "perturbation_level": "float64",
    "method": "str",
    "variant": "str",
    "refined": "bool",
    "reduction": "float64",
    "n_input": "int64",
    "target_count": "int64",
    "n_output": "Int64",
    "seed": "int64",
    "repeat": "int64",
    "status": "str",
    "message": "str",
    "runtime_s": "float64",
    "calibration_s": "float64",
    "cpu_s": "float64",
    "reference_s": "float64",
    "reference_cpu_s": "float64",
    "foreign_load": "float64",
    "peak_memory_mib": "float64",
    "subset": "boolean",
    "needs_mesh": "boolean",
    "settings": "object",
    "info": "object",
    "points_sha256": "str",
    "key": "str",
    "cloud": "str",
    "input": "str",
    "label": "str",
}
"""The columns that every frame has; those of metrics and stages follow."""


def _flat(record: Record) -> dict[str, Any]:
    """A record as one row of `Run.frame`."""
    row = {f.name: getattr(record, f.name) for f in fields(record) if f.name not in ("timings", "metrics")}
    done = "" if record.perturbation == "none" else f" + {record.perturbation} {record.perturbation_level:g}"
    row |= {"input": record.model + done, "label": record.variant + " + swaps" * record.refined}
    return {**record.metrics, **{f"time_{stage}_s": s for stage, s in record.timings.items()}, **row}


def load_run(path: str | Path) -> Run:
    """Read a run from its folder, or from its run.json; a run that was killed is read as far as it came.

    Parameters
    ----------
    path : str or Path
        The folder, or the file run.json in it.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        There is no run, the file is truncated or not a run, or a newer lpcompare wrote it.
    """
    path = Path(path)
    folder = path.parent if path.name == "run.json" else path
    document = _read_document(folder / "run.json")
    try:
        done = [Record.from_dict(row) for row in document["records"]]
        late = [] if document["complete"] else _read_lines(folder / "records.jsonl")
    except InputError as error:
        raise InputError(f"{folder}: {error} The run must be made again.") from error
    if not document["complete"]:
        done = list({record.case_id: record for record in (*done, *late)}.values())
    head = {name: document[name] for name in ("plan", "environment", "inputs", "complete")}
    return Run(folder=folder, records=tuple(done), **head)


def _read_document(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"{path.parent} holds no run.json; give the folder of a finished run.") from error
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is not a readable run ({error}).") from error
    version = document.get("schema_version") if isinstance(document, dict) else None
    if not isinstance(version, int):
        raise InputError(f"{path} is JSON but not a run of lpcompare: it has no schema_version.")
    if version > SCHEMA_VERSION:
        raise InputError(
            f"{path} has schema version {version}; this lpcompare reads up to {SCHEMA_VERSION}. "
            "Update lpcompare."
        )
    document = {"complete": True, "inputs": {}} | document
    for name, kind in (
        ("plan", dict),
        ("environment", dict),
        ("inputs", dict),
        ("records", list),
        ("complete", bool),
    ):
        if not isinstance(document.get(name), kind):
            raise InputError(
                f"{path} is not a run of lpcompare: its {name!r} is missing or of the wrong kind."
            )
    return document


def _read_lines(path: Path) -> list[Record]:
    """The finished rows of a run that did not end; a last line that was cut short is left out."""
    if not path.exists():
        return []
    try:
        rows = [json.loads(line) for line in path.read_text(encoding="utf-8").split("\n")[:-1]]
    except ValueError as error:
        raise InputError(f"{path.name} is damaged ({error}).") from error
    return [Record.from_dict(row) for row in rows]
