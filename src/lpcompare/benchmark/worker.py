"""The child process of one case: ``python -m lpcompare.benchmark.worker FOLDER``.

FOLDER/request.json says what to do. FOLDER/stage names what is being done, for the sentence of a process that
dies. FOLDER/reply.json is written after the call and again after each metric, each time whole, so that a
metric that kills the process leaves the method's own numbers; ``finished`` is true in the last one.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import math
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lpcompare.benchmark.limits import CANNOT_WRITE, die_with_parent, limit_memory, peak_memory_mib
from lpcompare.benchmark.verdict import fault, shortfall
from lpcompare.errors import InputError, LpcompareError, NotApplicable, Unavailable
from lpcompare.io.arrays import load_cloud, save_arrays
from lpcompare.registry import METHODS, METRICS
from lpcompare.types import Indices, PointCloud, Simplification

_SCALARS = (bool, int, float, str)
_MARKS = ("labels", "curvature", "feature_mask")
"""What a method may say of each original point; kept beside the result, for the report."""


class Case:
    """The method of a case with its settings, ready to be called on any cloud."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.name: str = request["method"]
        self.traits = METHODS.traits(self.name)
        self.settings: dict[str, Any] = dict(request["settings"])
        self.entropy: list[int] = request["entropy"]
        if self.settings:
            self.traits = replace(self.traits, exact_count=False)

    def generator(self) -> np.random.Generator:
        """A fresh generator of the case's seed."""
        return np.random.default_rng(np.random.SeedSequence(self.entropy))

    def load(self) -> None:
        """Import the method's file."""
        self.function, self.module = METHODS.get(self.name), METHODS.module(self.name)

    def calibrate(self, cloud: PointCloud, target: int) -> None:
        """Run the method's own search for its settings, if it has one."""
        if hasattr(self.module, "calibrate"):
            found = self._call(self.module.calibrate, cloud, target, self.generator())
            self.settings = {**found, **self.settings}

    def call(self, cloud: PointCloud, target: int, rng: np.random.Generator) -> Simplification:
        """The method's result."""
        return self._call(self.function, cloud, target, rng)

    def _call(self, function: Any, cloud: PointCloud, target: int, rng: np.random.Generator) -> Any:
        parameters = inspect.signature(function).parameters
        known = {"cloud": cloud} if "cloud" in parameters else {}
        chosen = {k: v for k, v in self.settings.items() if k in parameters}
        return function(cloud.points, target, rng=rng, **known, **chosen)

    def effective_settings(self) -> dict[str, Any]:
        """Every setting as it was used, JSON-ready."""
        settings = METHODS.settings(self.name) | self.settings
        return {k: v if v is None or isinstance(v, _SCALARS) else repr(v) for k, v in settings.items()}


@contextmanager
def handing_over() -> Iterator[None]:
    """End the process when the run's folder cannot be written: that is no fault of the method."""
    try:
        yield
    except (OSError, InputError):
        os._exit(CANNOT_WRITE)


class Reply:
    """What the parent reads when this process has ended, however it ends."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.fields: dict[str, Any] = {"status": "ok", "message": "", "metrics": {}}

    def stage(self, name: str) -> None:
        """Say what is being done."""
        with handing_over():
            (self.folder / "stage").write_text(name, encoding="utf-8")

    def write(self, **fields: Any) -> None:
        """Add fields and write the reply whole."""
        self.fields |= fields
        part = self.folder / "reply.part"
        text = json.dumps(self.fields)
        with handing_over():
            part.write_text(text, encoding="utf-8")
            os.replace(part, self.folder / "reply.json")


def main() -> None:
    """Run the case of the folder given on the command line."""
    folder = Path(sys.argv[1])
    request = json.loads((folder / "request.json").read_text(encoding="utf-8"))
    die_with_parent(request["parent"])
    limit_memory(request["memory_limit_mib"])
    reply = Reply(folder)
    try:
        result = _simplify(request, reply)
        if result is not None:
            _judge(request, result, reply)
        reply.write(finished=True)
    except (NotApplicable, Unavailable) as error:
        reply.write(status="skipped", message=str(error), finished=True)
    except MemoryError as error:
        limit = request["memory_limit_mib"]
        reply.write(status="failed", message=f"Out of memory (limit {limit} MiB): {error}.", finished=True)
    except LpcompareError as error:
        reply.write(status="failed", message=str(error), finished=True)
    except Exception as error:
        traceback.print_exc()
        reply.write(status="failed", message=f"{type(error).__name__}: {error}.", finished=True)


def _simplify(request: dict[str, Any], reply: Reply) -> Simplification | None:
    """Load, calibrate, warm up, time the call, check the result."""
    from lpcompare.benchmark.timing import OtherPrograms, reference_seconds, timed
    from lpcompare.benchmark.warmup import load_library, warm_up

    reply.stage("the import")
    others = OtherPrograms()
    case, target = Case(request), int(request["target_count"])
    load_library(case.traits)
    case.load()
    reply.stage("the warm-up")
    warm_up(case.call, case.traits)
    before, cloud = load_cloud(Path(request["input"])), load_cloud(Path(request["input"]))
    reply.stage("the calibration")
    _, search = timed(lambda: case.calibrate(cloud, target))
    before_call = reference_seconds()
    reply.stage("the call")
    result, seconds = timed(lambda: case.call(cloud, target, case.generator()))
    peak = peak_memory_mib()
    after_call = reference_seconds()
    reply.stage("the check of the result")
    wrong = fault(result, before, cloud, target, case.traits)
    reply.fields |= {
        "runtime_s": seconds.wall,
        "cpu_s": seconds.cpu,
        "calibration_s": search.wall if hasattr(case.module, "calibrate") else None,
        "reference_s": (before_call.wall + after_call.wall) / 2,
        "reference_cpu_s": (before_call.cpu + after_call.cpu) / 2,
        "foreign_load": others.load(),
        "peak_memory_mib": peak,
        "settings": case.effective_settings(),
        "needs_mesh": case.traits.needs_mesh,
    }
    if wrong:
        reply.write(status="failed", message=wrong)
        return None
    reply.fields["message"] = shortfall(len(result), target, case.traits)
    if request["refine"] and result.indices is not None:
        result = _refine(before, result, result.indices, reply)
    reply.write(**_facts(result))
    return result


def _refine(cloud: PointCloud, result: Simplification, rows: Indices, reply: Reply) -> Simplification:
    """Exchange points of a subset by `lpcompare.uniform`; its seconds count as runtime."""
    from lpcompare.benchmark.timing import timed
    from lpcompare.uniform.swaps import refine

    reply.stage("the refinement")
    indices, seconds = timed(lambda: refine(cloud.points, rows))
    reply.fields |= {"refined": True, "runtime_s": reply.fields["runtime_s"] + seconds.wall}
    reply.fields["cpu_s"] += seconds.cpu
    timings = {**result.timings, "refine": seconds.wall}
    return Simplification(cloud.points[indices], indices, timings, result.info)


def _facts(result: Simplification) -> dict[str, Any]:
    return {
        "n_output": len(result),
        "subset": result.indices is not None,
        "timings": {str(k): float(v) for k, v in result.timings.items()},
        "info": {str(k): v for k, v in result.info.items() if _is_scalar(v)},
        "points_sha256": hashlib.sha256(np.ascontiguousarray(result.points).data).hexdigest(),
    }


def _is_scalar(value: object) -> bool:
    return isinstance(value, _SCALARS) and not (isinstance(value, float) and not math.isfinite(value))


def _judge(request: dict[str, Any], result: Simplification, reply: Reply) -> None:
    """Measure the result against the clean cloud, one metric after another, and keep it."""
    from lpcompare.metrics.comparison import Comparison

    clean = load_cloud(Path(request["clean"]))
    comparison = Comparison(clean.points, result.points)
    for name in request["metrics"]:
        reply.stage(f"the metric {name}")
        try:
            values = METRICS.get(name)(comparison)
        except LpcompareError as error:
            reply.fields["message"] = f"{reply.fields['message']} Metric {name}: {error}".strip()
            values = {}
        numbers = {k: float(v) if math.isfinite(v) else None for k, v in values.items()}
        reply.write(metrics=reply.fields["metrics"] | numbers)
    reply.stage("the writing of the result")
    if request["output"]:
        arrays = {"points": result.points, "plane_errors": comparison.plane_errors(8).astype(np.float32)}
        if result.indices is not None:
            arrays["indices"] = result.indices
        arrays |= {name: result.info[name] for name in _MARKS if name in result.info}
        with handing_over():
            save_arrays(Path(request["output"]), arrays)


if __name__ == "__main__":
    main()
    sys.stderr.flush()
    os._exit(0)  # the reply is on disk; what libraries do at the end of a process would only be waited for
