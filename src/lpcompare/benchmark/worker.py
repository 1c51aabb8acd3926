"""The child process of one case: ``python -m lpcompare.benchmark.worker FOLDER``.

FOLDER/request.json says what to do and is removed at once. The answer is written whole after each step, to
the stream that the parent reads: a metric that ends the process leaves the method's own numbers.
"""

from __future__ import annotations

import hashlib
import math
import os
import signal
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
import numpy as np

from lpcompare.benchmark.case import Answer, Request
from lpcompare.benchmark.environment import library
from lpcompare.benchmark.record import Record
from lpcompare.benchmark.run_folder import file_digest
from lpcompare.benchmark.timing import OtherPrograms, peak_memory_mib, reference_seconds, timed
from lpcompare.errors import InputError, LpcompareError, MethodError, NotApplicable, Unavailable, printable
from lpcompare.io.arrays import digest, load_cloud, save_arrays
from lpcompare.metrics.comparison import Comparison
from lpcompare.processes.children import answer_stream
from lpcompare.processes.guard import PR_SET_PDEATHSIG, prctl
from lpcompare.registry import METHODS, METRICS, Invocation, call
from lpcompare.types import PointCloud, Simplification, Traits

_MARKS = ("labels", "curvature", "feature_mask")
"""What a method may say of each original point; kept beside the result, for the report."""

_ONE_GENERATOR_PER_PROCESS = "pymeshlab"
_MOST_FACTS, _LONGEST_NAME = 100, 100


class Trouble(Exception):  # noqa: N818 - its parent decides what it is
    """What is wrong is not the method: ``kind`` as in `Answer.trouble`."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind


class Reply:
    """What the parent is told."""

    def __init__(self, stream: BinaryIO, request: Request) -> None:
        self._stream = stream
        self.answer = Answer(request.token, request.record)

    @property
    def record(self) -> Record:
        """The record as it stands."""
        return self.answer.record

    def note(self, **fields: Any) -> None:
        """Add fields of the record."""
        record = replace(self.record, **fields)
        self.answer = msgspec.structs.replace(self.answer, record=record)

    def send(self, stage: str = "", *, finished: bool = False, trouble: str = "") -> None:
        """Tell what there is, and what is done next."""
        self.answer = msgspec.structs.replace(
            self.answer, stage=stage or self.answer.stage, finished=finished, trouble=trouble
        )
        self._stream.write(b"\n" + msgspec.json.encode(self.answer) + b"\n")
        self._stream.flush()

    def end(self, status: str, message: str, trouble: str = "") -> None:
        """Tell how it ended."""
        self.note(status=status, message=message)
        self.send(finished=True, trouble=trouble)


def prepare(methods: Sequence[str], metrics: Sequence[str]) -> None:
    """Call our own methods and metrics once, on a small cloud and one thread, before children are forked.

    What a rival imports, its own process imports: a library may start threads, which no fork takes along.
    MeshLab starts none before its first filter. cvxpy is imported, though few programs are left to a solver: a
    call's seconds must not hold that import. On a machine's first run the kernels are compiled here: those of
    the metrics by a second process.
    """
    from highspy import Highs
    from threadpoolctl import threadpool_limits

    own = [name for name in methods if METHODS.origin(name) == "lpcompare.methods"]
    for name in methods:
        if library(METHODS.traits(name)) == _ONE_GENERATOR_PER_PROCESS:
            _load_library(METHODS.traits(name))
    if own:
        import_module("cvxpy")
    with threadpool_limits(1):
        helper = _compile_apart(lambda: _try_metrics(metrics)) if own else None
        for name in own:
            call(name, _torus(), 64, random_state=0)
        if helper:
            os.waitpid(helper, 0)
        _try_metrics(metrics)
    Highs.resetGlobalScheduler(True)


def _try_metrics(metrics: Sequence[str]) -> None:
    points = _torus().points
    comparison = Comparison(points, points[::8])
    for name in metrics:
        if METRICS.origin(name) == "lpcompare.metrics":
            METRICS.get(name)(comparison)


def _compile_apart(work: Callable[[], None]) -> int:
    """Do some work in a copy of this process, for what it leaves in the cache on disk."""
    helper = os.fork()
    if not helper:
        prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        with suppress(Exception):
            work()
        os._exit(0)
    return helper


def main(folder: str) -> None:
    """Run the case of a folder."""
    path = Path(folder) / "request.json"
    request = msgspec.json.decode(path.read_bytes(), type=Request)
    path.unlink()
    reply = Reply(answer_stream(), request)
    try:
        if request.trial:
            _try_settings(request, reply)
        else:
            _judge(request, _simplify(request, reply), reply)
        reply.end("ok", reply.record.message)
    except Trouble as error:
        reply.end("failed", str(error), error.kind)
    except (NotApplicable, Unavailable) as error:
        reply.end("skipped", _text(error))
    except LpcompareError as error:
        reply.end("failed", _text(error).removeprefix(f"{request.record.method}: "))
    except BaseException as error:
        with suppress(Exception):
            traceback.print_exc(limit=20)
        kind = f"Out of memory{_memory_limit()}" if isinstance(error, MemoryError) else type(error).__name__
        reply.end("failed", f"{kind}: {_text(error)}.")


def _memory_limit() -> str:
    """The limit of this process, for a sentence; empty where it has none."""
    if sys.platform == "win32":
        return ""
    import resource

    limit = resource.getrlimit(resource.RLIMIT_DATA)[0]
    return "" if limit == resource.RLIM_INFINITY else f" (limit {limit // 2**20} MiB)"


def _try_settings(request: Request, reply: Reply) -> None:
    """Call the method with its settings on a small cloud, and where it does not want that, on the input."""
    record = request.record
    reply.send("the trial of the settings")
    with suppress(LpcompareError, TypeError, ValueError):
        call(record.method, _torus(), 64, settings=request.settings)
        return
    cloud = _load(request.input, request.input_sha256)
    try:
        call(
            record.method, cloud, record.target_count, random_state=_seed(request), settings=request.settings
        )
    except (NotApplicable, Unavailable, MethodError):
        return
    except (LpcompareError, TypeError, ValueError) as error:
        raise Trouble("settings", _text(error)) from error


def _simplify(request: Request, reply: Reply) -> tuple[PointCloud, Simplification]:
    """Load, warm up, calibrate, time the call, verify the result; returns the input and the result."""
    record = request.record
    reply.send("the import")
    others = OtherPrograms()
    traits = METHODS.traits(record.method)
    _load_library(traits)
    METHODS.get(record.method)
    reply.send("the warm-up")
    before, cloud = (_load(request.input, request.input_sha256) for _ in range(2))
    _warm_up(request, traits)
    invocation = Invocation(
        record.method, cloud, record.target_count, random_state=_seed(request), settings=request.settings
    )
    reply.send("the calibration")
    _, search = timed(invocation.calibrate)
    before_call = reference_seconds()
    reply.send("the call")
    result, seconds = timed(invocation.call)
    peak = peak_memory_mib()
    after_call = reference_seconds()
    reply.send("the check of the result")
    reply.note(
        runtime_s=seconds.wall,
        cpu_s=seconds.cpu,
        calibration_s=search.wall if invocation.has_calibration else None,
        reference_s=(before_call.wall + after_call.wall) / 2,
        reference_cpu_s=(before_call.cpu + after_call.cpu) / 2,
        foreign_load=others.load(),
        peak_memory_mib=peak,
        settings=_facts(invocation.effective_settings(), other=repr),
        needs_mesh=traits.needs_mesh,
    )
    reply.note(message=invocation.verify(result, before))
    if request.refine and result.indices is not None:
        result = _refine(before, result, reply)
    reply.note(
        n_output=len(result),
        subset=result.indices is not None,
        timings=_seconds(result.timings),
        info=_facts(result.info),
        points_sha256=hashlib.sha256(np.ascontiguousarray(result.points).data).hexdigest(),
    )
    return before, result


def _refine(cloud: PointCloud, result: Simplification, reply: Reply) -> Simplification:
    """Improve a subset by swaps; their seconds count as runtime."""
    from lpcompare.uniform.swaps import refine

    reply.send("the refinement")
    indices, seconds = timed(lambda: refine(cloud.points, np.asarray(result.indices)))
    record = reply.record
    reply.note(
        refined=True,
        runtime_s=(record.runtime_s or 0.0) + seconds.wall,
        cpu_s=(record.cpu_s or 0.0) + seconds.cpu,
    )
    timings = {**result.timings, "refine": seconds.wall}
    return replace(result, points=cloud.points[indices], indices=indices, timings=timings)


def _judge(request: Request, done: tuple[PointCloud, Simplification], reply: Reply) -> None:
    """Measure the result against the clean cloud, one metric after another, and keep it."""
    clean, result = done
    if request.clean:
        clean = _load(request.clean, request.clean_sha256)
    comparison = Comparison(clean.points, result.points)
    for name in request.metrics:
        reply.send(f"the metric {name}")
        try:
            values = _seconds(METRICS.get(name)(comparison))
        except MemoryError:
            raise
        except Exception as error:
            reply.note(message=f"{reply.record.message} Metric {name}: {_text(error)}".strip())
            continue
        reply.note(metrics={**reply.record.metrics, **values})
    if request.output:
        reply.send("the writing of the result")
        arrays = {"plane_errors": comparison.plane_errors(8).astype(np.float32)} if request.metrics else {}
        _keep(Path(request.output), result, arrays, reply)


def _keep(path: Path, result: Simplification, arrays: dict[str, np.ndarray], reply: Reply) -> None:
    arrays = {"points": result.points, **arrays}
    if result.indices is not None:
        arrays["indices"] = np.asarray(result.indices)
    marks = {name: np.asarray(result.info[name]) for name in _MARKS if name in result.info}
    arrays |= {name: mark for name, mark in marks.items() if mark.dtype.kind in "biuf"}
    try:
        save_arrays(path, arrays)
    except InputError as error:
        raise Trouble("output", f"The process could not write its result: {error}") from error
    reply.note(cloud_sha256=file_digest(path))


def _load_library(traits: Traits) -> None:
    """Import the library that the method wraps; what is missing is the method's to report."""
    for name in (library(traits), *traits.requires):
        with suppress(ImportError):
            import_module(name)


def _warm_up(request: Request, traits: Traits) -> None:
    """Call the method once on a small closed mesh, so that lazy imports and thread pools are not timed.

    MeshLab's methods are left out: they draw from one generator per process that cannot be seeded, and give
    the same points again only after the same calls in a fresh process. An error is left to the call itself.
    """
    if library(traits) == _ONE_GENERATOR_PER_PROCESS:
        return
    try:
        call(request.record.method, _torus(8), 16, settings=request.settings)
    except MemoryError:
        raise
    except Exception:
        return


def _torus(n_around: int = 16) -> PointCloud:
    from lpcompare.models.synthetic import torus

    return torus(n_around, n_around)


def _load(path: str, sha256: str) -> PointCloud:
    """A cloud on disk, which another method may have changed."""
    try:
        cloud = load_cloud(Path(path))
    except InputError as error:
        raise Trouble("input", str(error)) from error
    if digest(cloud) != sha256:
        raise Trouble("input", f"{path} is not the cloud that this run has written.")
    return cloud


def _seed(request: Request) -> np.random.SeedSequence:
    return np.random.SeedSequence(request.entropy)


def _text(error: BaseException) -> str:
    """An error's text in one line; an error may fail to have one."""
    try:
        return printable(str(error))
    except Exception:
        return "no text"


def _seconds(values: Mapping[str, Any]) -> dict[str, float]:
    """Numbers as plain floats by plain names; NaN becomes null on its way."""
    return {_name(k): float(v) for k, v in list(values.items())[:_MOST_FACTS]}


def _facts(values: Mapping[str, Any], other: Any = None) -> dict[str, Any]:
    """The plain values of a mapping, bounded; others as ``other`` makes text of them, or left out."""
    facts = {}
    for key, given in list(values.items())[:_MOST_FACTS]:
        value = _plain(given.item() if isinstance(given, np.generic) else given)
        if value is None and given is not None and other is not None:
            value = printable(other(given))
        if value is not None or other is not None:
            facts[_name(key)] = value
    return facts


def _plain(value: Any) -> bool | int | float | str | None:
    """A truth value, a finite number or a text, also of a subclass; None for anything else."""
    if isinstance(value, str):
        return printable(str(value))
    if isinstance(value, bool):
        return value
    if isinstance(value, int) and abs(value) < 2**63:
        return int(value)
    return float(value) if isinstance(value, float) and math.isfinite(value) else None


def _name(key: object) -> str:
    return printable(str(key), _LONGEST_NAME)


if __name__ == "__main__":
    main(sys.argv[1])
    sys.stderr.flush()
    os._exit(0)  # the answer is told; what libraries do at the end of a process would only be waited for
