"""Methods of one run held against one of them, paired over models, reductions, seeds and repeats."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from lpcompare.benchmark.record import Record
from lpcompare.report.statistics import Difference, holm, paired_difference, verdict

BASELINE = "poisson_disk"


@dataclass(frozen=True)
class MethodRatio:
    """A variant against the baseline.

    Attributes
    ----------
    variant : str
    error, runtime : Difference
        Of the logarithms of eq. 27 errors and of seconds; one difference per model, damage, reduction and
        seed, after the mean over repeats, because repeats of one case are not independent.
    error_verdict, runtime_verdict : str
        "better", "worse", "faster", "slower", "n.s." or "too few pairs".
    """

    variant: str
    error: Difference
    runtime: Difference
    error_verdict: str
    runtime_verdict: str


def compare_methods(records: Iterable[Record], baseline: str = BASELINE) -> list[MethodRatio]:
    """Every variant with at least one pair, by its mean error ratio; empty without the baseline."""
    errors, runtimes = _log_means(records)
    if baseline not in errors:
        return []
    names = [name for name in errors if name != baseline and errors[name].keys() & errors[baseline].keys()]
    by_error = [_difference(errors[name], errors[baseline]) for name in names]
    by_runtime = [_difference(runtimes[name], runtimes[baseline]) for name in names]
    adjusted = [holm([d.p_value for d in group]) for group in (by_error, by_runtime)]
    rows = [
        MethodRatio(name, e, t, verdict(e, p, "worse", "better"), verdict(t, q, "slower", "faster"))
        for name, e, t, p, q in zip(names, by_error, by_runtime, *adjusted, strict=True)
    ]
    return sorted(rows, key=lambda row: row.error.mean)


def _log_means(
    records: Iterable[Record],
) -> tuple[dict[str, dict[object, float]], dict[str, dict[object, float]]]:
    """Variant -> case -> mean over the repeats of the logarithm, of errors and of runtimes."""
    groups: dict[tuple[str, object], list[Record]] = defaultdict(list)
    for r in records:
        error = r.metrics.get("plane_error_pct", math.nan)
        if r.status == "ok" and r.runtime_s and math.isfinite(error) and error > 0:
            case = (r.model, r.perturbation, r.perturbation_level, r.reduction, r.seed)
            groups[r.variant, case].append(r)
    errors: dict[str, dict[object, float]] = defaultdict(dict)
    runtimes: dict[str, dict[object, float]] = defaultdict(dict)
    for (variant, case), group in groups.items():
        errors[variant][case] = sum(math.log(r.metrics["plane_error_pct"]) for r in group) / len(group)
        runtimes[variant][case] = sum(math.log(r.runtime_s or math.nan) for r in group) / len(group)
    return errors, runtimes


def _difference(ours: dict[object, float], baseline: dict[object, float]) -> Difference:
    return paired_difference([ours[case] - baseline[case] for case in ours if case in baseline])
