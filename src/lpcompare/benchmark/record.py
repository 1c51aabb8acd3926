"""The records of a run, one per case and repeat, and the run as one table; docs/run-json.md has the files."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import msgspec

from lpcompare.errors import InputError, printable

if TYPE_CHECKING:
    from pandas import DataFrame

SCHEMA_VERSION = 2

Status = Literal["ok", "skipped", "failed", "timeout"]
STATUSES: tuple[str, ...] = get_args(Status)
Count = Annotated[int, msgspec.Meta(ge=0, le=2**62)]
CloudFile = Annotated[str, msgspec.Meta(pattern=r"^(clouds/[^/\\\x00]+\.npz)?$")]
Name = Annotated[str, msgspec.Meta(max_length=300)]
Numbers = Annotated[Mapping[Name, float | None], msgspec.Meta(max_length=1000)]
Facts = Annotated[Mapping[Name, Any], msgspec.Meta(max_length=1000)]

_TEXTS = ("model", "method", "variant", "perturbation", "message")
_NESTED = ("timings", "metrics")


@dataclass(frozen=True)
class Record:
    """One case, run once. `msgspec` checks every field of a file that is read.

    Attributes
    ----------
    model, method : str
        Registered names, or a file's stem.
    reduction : float
        Share of the points removed.
    n_input, target_count : int
        Points of the input, points asked for.
    seed, repeat : int
    status : str
        ``ok``, ``skipped`` (declined or not installed), ``failed`` or ``timeout``.
    message : str
        Why, where the status is not ok; a word on what fell short where it is.
    variant : str
        The method with the settings that were chosen, for example ``lp_density n_clusters=25``.
    perturbation, perturbation_level : str, float
        What was done to the input; ``none`` for the clean cloud.
    refined : bool
        Whether swaps (`lpcompare.uniform.swaps`) improved the result.
    n_output : int or None
        Points returned.
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
    settings : mapping
        Effective settings of the method, calibrated ones among them.
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
    cloud_sha256 : str
        Digest of that file.
    """

    model: Name
    method: Name
    reduction: float
    n_input: Count
    target_count: Count
    seed: Count
    repeat: Count
    status: Status
    message: str = ""
    variant: str = ""
    perturbation: str = "none"
    perturbation_level: float = 0.0
    refined: bool = False
    n_output: Count | None = None
    runtime_s: float | None = None
    calibration_s: float | None = None
    cpu_s: float | None = None
    reference_s: float | None = None
    reference_cpu_s: float | None = None
    foreign_load: float | None = None
    peak_memory_mib: float | None = None
    subset: bool | None = None
    needs_mesh: bool | None = None
    settings: Facts = field(default_factory=dict)
    timings: Numbers = field(default_factory=dict)
    metrics: Numbers = field(default_factory=dict)
    info: Facts = field(default_factory=dict)
    points_sha256: str = ""
    key: str = ""
    cloud: CloudFile = ""
    cloud_sha256: str = ""

    def __post_init__(self) -> None:
        for name in _TEXTS:
            object.__setattr__(self, name, printable(getattr(self, name)))
        object.__setattr__(self, "variant", self.variant or self.method)
        for name in _NESTED:
            numbers = {k: math.nan if v is None else v for k, v in getattr(self, name).items()}
            object.__setattr__(self, name, numbers)

    @property
    def case_id(self) -> tuple[object, ...]:
        """Which case of a plan this is the record of, however it was run."""
        perturbation = (self.perturbation, self.perturbation_level)
        return (self.model, perturbation, self.variant, self.reduction, self.seed, self.repeat)

    def to_dict(self) -> dict[str, Any]:
        """The record as JSON-ready values; NaN becomes null."""
        return msgspec.json.decode(msgspec.json.encode(self))


@dataclass(frozen=True, repr=False)
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
    n_damaged : int
        Records that could not be read and are left out.

    Examples
    --------
    >>> import lpcompare
    >>> done = lpcompare.run(["cube"], ["random_sample"], reductions=[0.9])
    >>> done.complete, len(done.records), done.frame.n_output.tolist()
    (True, 1, [960])
    """

    folder: Path
    plan: Mapping[str, Any]
    environment: Mapping[str, Any]
    inputs: Mapping[str, Mapping[str, Any]]
    records: tuple[Record, ...]
    complete: bool
    n_damaged: int = 0

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
        return frame_of(self.records)

    def report(self, path: str | Path | None = None) -> Path:
        """Write the page of this run, one HTML file that needs no network, and return its path.

        Parameters
        ----------
        path : str or Path, optional
            Default: report.html in the run's folder.
        """
        from lpcompare.report.page import write_page

        return write_page(self.folder, None if path is None else Path(path))

    def __repr__(self) -> str:
        statuses = [record.status for record in self.records]
        counts = ", ".join(f"{statuses.count(s)} {s}" for s in dict.fromkeys(statuses))
        models = ", ".join(dict.fromkeys(record.model for record in self.records))
        state = "" if self.complete else ", not complete"
        return f"Run({models or 'no records'}: {counts or '0 cases'}{state}; {self.folder})"

    def _repr_html_(self) -> str:
        columns = [name for name in ("plane_error_pct", "runtime_s") if name in self.frame]
        medians = self.frame.groupby(["input", "label", "reduction"], sort=False)[columns].median()
        return medians.to_html(float_format="{:.4g}".format)


_TYPES = {
    "Name": "str",
    "str": "str",
    "Status": "str",
    "CloudFile": "str",
    "float": "float64",
    "float | None": "float64",
    "Count": "int64",
    "Count | None": "Int64",
    "bool": "bool",
    "bool | None": "boolean",
    "Facts": "object",
}
_COLUMNS = {f.name: _TYPES[str(f.type)] for f in fields(Record) if f.name not in _NESTED}
_COLUMNS |= {"input": "str", "label": "str"}
"""The columns that every frame has; those of metrics and stages follow."""


def frame_of(records: Iterable[Record]) -> DataFrame:
    """The table of `Run.frame`."""
    import pandas as pd

    rows = [_row(record) for record in records]
    names = dict.fromkeys(name for row in rows for name in row)
    columns = [*_COLUMNS, *(name for name in names if name not in _COLUMNS)]
    return pd.DataFrame(rows, columns=columns).astype(_COLUMNS)


def _row(record: Record) -> dict[str, Any]:
    done = "" if record.perturbation == "none" else f" + {record.perturbation} {record.perturbation_level:g}"
    own = {name: value for name, value in vars(record).items() if name not in _NESTED}
    own |= {"input": record.model + done, "label": record.variant + " + swaps" * record.refined}
    return {**record.metrics, **{f"time_{stage}_s": s for stage, s in record.timings.items()}, **own}


def load_run(folder: str | Path) -> Run:
    """Read a run from its folder; one that was killed is read as far as it came.

    Parameters
    ----------
    folder : str or Path
        The folder, or the file run.json in it.

    Returns
    -------
    Run
        Records that are damaged are left out and counted.

    Raises
    ------
    InputError
        There is no run, run.json is truncated or not a run, or a newer lpcompare wrote it.

    Examples
    --------
    >>> import tempfile
    >>> from lpcompare.benchmark.runner import run
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = run(["cube"], ["random_sample"], reductions=[0.9], out=folder)
    ...     print(load_run(folder).frame.status.tolist())
    ['ok']
    """
    path = Path(folder)
    path = path if path.name == "run.json" else path / "run.json"
    document = _read_document(path)
    texts: list[bytes | msgspec.Raw] = [*document.records]
    if not document.complete:
        texts += _lines(path.with_name("records.jsonl"))
    found = [record for text in texts if (record := _read_record(text))]
    n_damaged = len(texts) - len(found)
    if not document.complete:  # a case may have been taken over and then run again
        found = list({record.case_id: record for record in found}.values())
    return Run(
        folder=path.parent,
        plan=document.plan,
        environment=document.environment,
        inputs={name: msgspec.to_builtins(facts) for name, facts in document.inputs.items()},
        records=tuple(found),
        complete=document.complete,
        n_damaged=n_damaged,
    )


def line_of(record: Record) -> bytes:
    """A record as a line of records.jsonl, with a digest that tells damage."""
    text = msgspec.json.encode(record)
    return msgspec.json.encode(_Line(_digest(text), msgspec.Raw(text))) + b"\n"


class _Line(msgspec.Struct):
    digest: str
    record: msgspec.Raw


class _Input(msgspec.Struct):
    file: CloudFile
    model: str
    n_points: int
    sha256: str = ""
    left_out: str | msgspec.UnsetType = msgspec.UNSET


class _Version(msgspec.Struct):
    schema_version: int


class _Document(msgspec.Struct):
    """run.json; its records are read one by one."""

    plan: dict[str, Any]
    environment: dict[str, Any]
    records: list[msgspec.Raw]
    inputs: dict[str, _Input] = {}
    complete: bool = True


def _read_document(path: Path) -> _Document:
    if not path.is_file():
        raise InputError(f"{path.parent} holds no run.json; give the folder of a finished run.")
    try:
        text = path.read_bytes()
        version = msgspec.json.decode(text, type=_Version).schema_version
        if version <= SCHEMA_VERSION:
            return msgspec.json.decode(text, type=_Document)
    except (OSError, ValueError, RecursionError) as error:
        reason = printable(str(error), 300)
        raise InputError(f"{path} is not a readable run of lpcompare ({reason}).") from error
    raise InputError(
        f"{path} has schema version {version}; this lpcompare reads up to {SCHEMA_VERSION}. Update lpcompare."
    )


def _lines(path: Path) -> list[bytes]:
    """The lines of a run that did not end; a last one that was cut short is among them."""
    if not path.is_file():
        return []
    return [line for line in path.read_bytes().split(b"\n") if line]


def _read_record(text: bytes | msgspec.Raw) -> Record | None:
    """The record of a line, of a line of schema 1, or of run.json; None where it is damaged."""
    try:
        if isinstance(text, bytes) and text.startswith(b'{"digest"'):
            line = msgspec.json.decode(text, type=_Line)
            if _digest(bytes(line.record)) != line.digest:
                return None
            text = line.record
        return msgspec.json.decode(text, type=Record)
    except (ValueError, RecursionError):
        return None


def _digest(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:16]
