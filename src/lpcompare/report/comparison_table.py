"""The tables that ``lpcompare compare`` prints, at most 100 columns wide."""

from __future__ import annotations

import math
import textwrap

from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.report.alignment import WIDTH, align, cut
from lpcompare.report.cells import gather_cells
from lpcompare.report.columns import headings
from lpcompare.report.comparison import (
    RUNTIME_MARGIN,
    MethodDifference,
    compare_runs,
    differing_environment,
    was_busy,
)
from lpcompare.report.ranks import rank_over_models
from lpcompare.report.statistics import Difference
from lpcompare.report.within import BASELINE, compare_methods

_HEAD = ("method", "pairs", "wall ratio", "CPU ratio", "runtime", "eq. 27", "error", "same")


def format_comparison(first: Run, second: Run) -> str:
    """Differences from the first run to the second."""
    rows = [_row(difference) for difference in compare_runs(first, second)]
    lines = align([_HEAD, *rows], frozenset({0, 4, 6}))
    changed = [f"  {k}: {a} -> {b}" for k, (a, b) in differing_environment(first, second).items()]
    parts = [
        f"{first.folder} -> {second.folder}",
        *lines[:1],
        "-" * max(map(len, lines)),
        *lines[1:],
        *textwrap.wrap(_legend(first, second), WIDTH),
        *(["What else is different:", *(line[:WIDTH] for line in changed)] if changed else []),
    ]
    return "\n".join(parts)


def format_methods(run: Run) -> str:
    """The methods of one run against Poisson disk; their ranks where there are models enough."""
    rows = [
        (
            cut(row.variant),
            str(row.error.n),
            f"{math.exp(row.error.mean):.3f}",
            _ratios(row.error),
            row.error_verdict,
            f"{math.exp(row.runtime.mean):.3g}",
            row.runtime_verdict,
        )
        for row in compare_methods(run.records)
    ]
    if not rows:
        raise InputError(f"{run.folder} holds no results of {BASELINE} to hold the others against.")
    head = ("method", "cases", "error ratio", "95 % interval", "error", "time ratio", "runtime")
    lines = align([head, *rows], frozenset({0, 4, 6}))
    text = (
        f"Ratios to {BASELINE}, geometric means over the cases (model, damage, reduction, seed). Called "
        "different at 5 % over all methods (paired t on logarithms, Holm); n.s.: not significant."
    )
    return "\n".join(
        [lines[0], "-" * max(map(len, lines)), *lines[1:], *textwrap.wrap(text, WIDTH), *_ranks(run)]
    )


def _ranks(run: Run) -> list[str]:
    ranking = rank_over_models(gather_cells(run.records), headings(["plane_error_pct"])["plane_error_pct"])
    if math.isnan(ranking.p_value):
        return ["Ranks over models with their critical difference need at least 3 models and 3 methods."]
    ranks = ", ".join(f"{m} {r:.2f}" for m, r in zip(ranking.methods, ranking.mean_ranks, strict=True))
    text = (
        f"Mean ranks over {len(ranking.blocks)} models: {ranks}. Friedman p = {ranking.p_value:.2g}; methods "
        f"differ when their ranks are more than {ranking.critical_difference:.2f} apart (Nemenyi, 5 %)."
    )
    return textwrap.wrap(text, WIDTH)


def _row(difference: MethodDifference) -> tuple[str, ...]:
    error = difference.error
    return (
        cut(difference.variant, 29),
        str(difference.n_pairs),
        _ratios(difference.wall),
        _ratios(difference.cpu),
        difference.runtime_verdict,
        "-" if error is None else f"{error.mean:+.2g}",
        difference.error_verdict,
        f"{difference.same_points}",
    )


def _ratios(difference: Difference | None) -> str:
    if difference is None or math.isnan(difference.low):
        return "-"
    return f"{math.exp(difference.low):.2f} .. {math.exp(difference.high):.2f}"


def _legend(first: Run, second: Run) -> str:
    busy = any(was_busy(run) for run in (first, second))
    parallel = any(run.plan.get("jobs", 1) > 1 for run in (first, second))
    return (
        "Ratios: second run over first, 95 % interval of the geometric mean over the pairs, by wall clock "
        "and in processor time, both in units of a fixed piece of work done around each call. eq. 27: % "
        "of the diagonal; same: pairs with identical points. Called different at 5 % over all methods "
        f"(paired t on logarithms, Holm), runtimes only beyond {100 * RUNTIME_MARGIN:g} %; "
        "n.s.: not significant; too short: below 5 ms."
        + " Other programs kept the machine busy in one of the runs: no runtime is judged." * busy
        + " Cases ran side by side: the runtimes are unreliable." * parallel
    )
