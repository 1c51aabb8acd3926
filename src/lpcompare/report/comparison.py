"""Two runs side by side: two machines, two versions, before and after.

Records are paired by model, damage, variant, reduction, seed and repeat. Runtimes are compared in units of
the reference work that each child process did around its call (`lpcompare.benchmark.timing`), so that a
machine that was busy in one run does not make every method look slower. A difference is called one only
when its p-value, adjusted for the number of methods (Holm), is below 5 %; of runtimes, only beyond a margin
as well.
Where the machine was busy in either run, runtimes are not judged at all: a program on the other processor
slows some methods by a third and others not, and processor time is no refuge from it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median

from lpcompare.benchmark.record import Record, Run
from lpcompare.errors import InputError
from lpcompare.report.statistics import Difference, holm, paired_difference, verdict

RUNTIME_MARGIN = 0.05
"""Runtimes that differ by less than 5 % are not told apart."""

SHORTEST_S = 0.005
"""Calls shorter than 5 ms are not judged: what ran before them decides their time."""

_LARGEST_FOREIGN_LOAD = 0.1
_LONGEST_WAIT = 0.1


@dataclass(frozen=True)
class MethodDifference:
    """How a variant differs between two runs.

    Attributes
    ----------
    variant : str
    n_pairs : int
    seconds : float
        Median runtime over both runs.
    wall, cpu : Difference or None
        Of the logarithms of the runtimes, in units of the reference work: on the wall clock, which is judged,
        and of all processors together; None where the runs have no such seconds.
    error : Difference or None
        Of the eq. 27 errors, in % of the diagonal.
    same_points : int
        Pairs whose points are identical.
    runtime_verdict : str
        "slower", "faster", "n.s.", "busy" (the machine), "too short" or "too few pairs".
    error_verdict : str
        "worse", "better", "identical", "n.s." or "too few pairs".
    """

    variant: str
    n_pairs: int
    seconds: float
    wall: Difference | None
    cpu: Difference | None
    error: Difference | None
    same_points: int
    runtime_verdict: str = ""
    error_verdict: str = ""


def compare_runs(first: Run, second: Run) -> list[MethodDifference]:
    """Differences from the first run to the second, variant by variant.

    Raises
    ------
    InputError
        The runs are of different inputs, or have no case in common.
    """
    check_inputs(first, second)
    pairs = pair_records(first.records, second.records)
    if not pairs:
        raise InputError(f"{first.folder} and {second.folder} have no finished case in common.")
    measured = [_measure(variant, group) for variant, group in pairs.items()]
    busy = was_busy(first) or was_busy(second)
    runtimes = holm([_p_value(m.wall) for m in measured])
    errors = holm([_p_value(m.error) for m in measured])
    judged = map(_judge, measured, runtimes, errors)
    return [replace(one, runtime_verdict="busy") if busy else one for one in judged]


def was_busy(run: Run) -> bool:
    """Whether other programs held a tenth of a processor, or the reference work waited a tenth of its time.

    A short call slips through between two waits and a long one does not, and what shares a processor's memory
    slows what needs it: no clock can be believed then.
    """
    loads = [r.foreign_load for r in run.records if r.foreign_load is not None]
    waits = [r.reference_s / r.reference_cpu_s for r in run.records if r.reference_s and r.reference_cpu_s]
    loaded = bool(loads) and median(loads) > _LARGEST_FOREIGN_LOAD
    return loaded or (bool(waits) and median(waits) > 1 + _LONGEST_WAIT)


def check_inputs(first: Run, second: Run) -> None:
    """Refuse runs whose inputs differ; raises `InputError`."""
    ours, theirs = ({name: i["sha256"] for name, i in run.inputs.items()} for run in (first, second))
    different = sorted(name for name in ours.keys() & theirs.keys() if ours[name] != theirs[name])
    if different:
        names = ", ".join(different)
        raise InputError(
            f"{first.folder} and {second.folder} were run on different inputs: {names} is not the same cloud."
        )
    if not ours.keys() & theirs.keys():
        raise InputError(
            f"{first.folder} and {second.folder} share no input: {', '.join(ours)} and {', '.join(theirs)}."
        )


def pair_records(first: Sequence[Record], second: Sequence[Record]) -> dict[str, list[tuple[Record, Record]]]:
    """Records that are ok in both runs and were asked the same, by variant."""
    others = {_identity(record): record for record in second if record.status == "ok"}
    pairs: dict[str, list[tuple[Record, Record]]] = defaultdict(list)
    for record in first:
        other = others.get(_identity(record))
        if record.status == "ok" and other is not None:
            pairs[record.variant].append((record, other))
    return dict(pairs)


def differing_environment(first: Run, second: Run) -> dict[str, tuple[str, str]]:
    """What of the machine and the software is not the same in both runs."""
    ours, theirs = (_facts(run.environment) for run in (first, second))
    names = [name for name in dict.fromkeys((*ours, *theirs)) if ours.get(name) != theirs.get(name)]
    return {name: (ours.get(name, "-"), theirs.get(name, "-")) for name in names}


def _identity(record: Record) -> tuple[object, ...]:
    return (*record.case_id, record.refined)


def _measure(variant: str, pairs: list[tuple[Record, Record]]) -> MethodDifference:
    errors = [
        b.metrics.get("plane_error_pct", math.nan) - a.metrics.get("plane_error_pct", math.nan)
        for a, b in pairs
    ]
    return MethodDifference(
        variant,
        len(pairs),
        median([r.runtime_s or 0.0 for pair in pairs for r in pair]),
        _speed_difference(pairs, "runtime_s", "reference_s"),
        _speed_difference(pairs, "cpu_s", "reference_cpu_s"),
        paired_difference(errors) if errors and all(map(math.isfinite, errors)) else None,
        sum(a.points_sha256 == b.points_sha256 for a, b in pairs),
    )


def _speed_difference(pairs: list[tuple[Record, Record]], call: str, reference: str) -> Difference | None:
    """Of the logarithms of ``call`` over ``reference``; None where a record lacks one of them."""
    speeds = [[(getattr(r, call) or 0) / (getattr(r, reference) or 1) for r in pair] for pair in pairs]
    if not all(a > 0 and b > 0 for a, b in speeds):
        return None
    return paired_difference([math.log(b / a) for a, b in speeds], math.log1p(RUNTIME_MARGIN))


def _p_value(difference: Difference | None) -> float:
    return difference.p_value if difference else 1.0


def _judge(measured: MethodDifference, runtime_p: float, error_p: float) -> MethodDifference:
    runtime = verdict(measured.wall, runtime_p, "slower", "faster")
    error = verdict(measured.error, error_p, "worse", "better")
    if measured.error is not None and measured.error.low == measured.error.high == 0:
        error = "identical"
    if measured.seconds < SHORTEST_S:
        runtime = "too short"
    return replace(measured, runtime_verdict=runtime, error_verdict=error)


def _facts(environment: Mapping[str, object]) -> dict[str, str]:
    names = ("cpu", "cores_allowed", "memory_mib", "os", "python", "commit")
    plain = {name: str(environment.get(name, "-")) for name in names}
    packages, threads = environment.get("packages", {}), environment.get("threads", {})
    nested = {**packages, **threads} if isinstance(packages, dict) and isinstance(threads, dict) else {}
    return plain | {str(k): str(v) for k, v in nested.items()}
