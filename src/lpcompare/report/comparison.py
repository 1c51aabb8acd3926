"""Two runs side by side, or the methods of one run against a reference: paired differences, and verdicts.

Rows of two runs are paired by model, perturbation, method, reduction, seed and repeat. Runtimes are compared
in units of the reference work that each child process did around its call (`lpcompare.benchmark.timing`): a
machine that was busy in one run does not make every method look slower. Where other programs kept the machine
busy in either run, runtimes are not judged at all: a program on the other processor slows some methods by a
third and others not, and processor time is no refuge from it.

An interval and the verdict beside it are one statement. The methods are tested in Holm's order, and each
interval has the level at which its method was tested: a difference is called one where the interval lies
beyond the margin, and of all differences called, none is false with a probability of 95 %.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.report.cells import ERROR, REFERENCE, RUNTIME, cells
from lpcompare.report.ranks import rank_over_models
from lpcompare.report.tables import NARROW, align, plain

LEVEL = 0.05
RUNTIME_MARGIN = 0.05
"""Runtimes that differ by less than 5 % are not told apart."""

SHORTEST_S = 0.005
"""Calls shorter than 5 ms are not judged: what ran before them decides their time."""

_LARGEST_FOREIGN_LOAD = 0.1
_LONGEST_WAIT = 0.1
_CASE = ["model", "perturbation", "perturbation_level", "reduction", "seed"]


def paired_differences(groups: Mapping[str, Sequence[float]], margin: float = 0.0) -> pd.DataFrame:
    """Mean of the paired differences of each group, by Student's t, and whether it lies beyond a margin.

    Parameters
    ----------
    groups : mapping of str to sequence of float
        One difference per pair; of ratios, their logarithms. NaN is left out.
    margin : float
        Differences up to this are of no interest.

    Returns
    -------
    DataFrame
        Indexed by group: ``n``, ``mean``, the interval ``low`` to ``high`` at the level of Holm's step
        (infinite below two pairs), and ``sign``: 1 or -1 where the interval lies beyond the margin, else 0.
    """
    values = [pd.Series(v, dtype=float).dropna() for v in groups.values()]
    n, mean, error = (np.array([f(v) for v in values]) for f in (len, pd.Series.mean, pd.Series.sem))
    constant, single = error == 0, n < 2
    with np.errstate(divide="ignore", invalid="ignore"):
        p_values = 2 * stats.t.sf((np.abs(mean) - margin) / error, n - 1)
    p_values = np.where(constant, np.abs(mean) <= margin, p_values.clip(max=1))
    levels = holm_levels(np.where(single, 1.0, p_values))
    half = np.where(constant, 0.0, stats.t.ppf(1 - levels / 2, np.maximum(n - 1, 1)) * error)
    half = np.where(single, np.inf, half)
    table = pd.DataFrame({"n": n, "mean": mean, "low": mean - half, "high": mean + half}, list(groups))
    return table.assign(sign=(table.low > margin).astype(int) - (table.high < -margin))


def holm_levels(p_values: Sequence[float] | np.ndarray) -> np.ndarray:
    """The level of each test in Holm's order, smallest p first; after the first that fails, its level stays.

    A p-value below its level is significant: of all such calls, none is false with 1 - `LEVEL`.
    """
    order = np.argsort(p_values, kind="stable")
    steps = LEVEL / np.arange(len(order), 0, -1)
    failed = np.flatnonzero(np.asarray(p_values)[order] >= steps)
    levels = np.empty(len(order))
    levels[order] = np.minimum(steps, steps[failed[0]]) if len(failed) else steps
    return levels


def compare_runs(first: Run, second: Run) -> pd.DataFrame:
    """Differences from the first run to the second.

    Returns
    -------
    DataFrame
        Indexed by method: ``n_pairs``, ``same`` (pairs with identical points), median ``seconds`` over both
        runs; ``wall``, ``cpu`` (logarithms of the runtimes in units of the reference work) and ``error`` (eq.
        27, % of the diagonal), each with ``_n``, ``_low``, ``_high``, ``_sign``; ``runtime`` ("slower",
        "faster", "n.s.", "busy", "too short" or "few pairs") and ``quality`` ("worse", "better", "identical",
        "n.s." or "few pairs").

    Raises
    ------
    InputError
        The runs are of different inputs, or have no case in common.
    """
    check_inputs(first, second)
    pairs = _pairs(first.frame, second.frame)
    if pairs.empty:
        raise InputError(f"{first.folder} and {second.folder} have no finished case in common.")
    groups = pairs.groupby("label", sort=False)
    table = groups.agg(n_pairs=("same", "size"), same=("same", "sum"), seconds=("seconds", "median"))
    for name, margin in (("wall", math.log1p(RUNTIME_MARGIN)), ("cpu", 0.0), ("error", 0.0)):
        table = table.join(_differences(pairs.set_index("label")[name], name, margin))
    table["runtime"] = _verdicts(table, "wall", "slower", "faster")
    table["quality"] = _verdicts(table, "error", "worse", "better")
    table.loc[table.error_low.eq(0) & table.error_high.eq(0), "quality"] = "identical"
    table.loc[table.seconds < SHORTEST_S, "runtime"] = "too short"
    return table.assign(runtime="busy") if was_busy(first) or was_busy(second) else table


def compare_methods(run: Run) -> pd.DataFrame:
    """Every method of one run against Poisson disk, the lowest error first; empty without that.

    Returns
    -------
    DataFrame
        Indexed by method: ``error`` and ``time``, logarithms of the ratios (one per model, perturbation,
        reduction and seed, after the mean over repeats, because repeats of one case are not independent),
        each with ``_n``, ``_low``, ``_high``, ``_sign``; ``quality`` and ``runtime`` as in `compare_runs`.
    """
    good = run.frame.reindex(columns=[*_CASE, "label", "status", ERROR, RUNTIME])
    good = good[good.status.eq("ok") & good[ERROR].gt(0) & good[RUNTIME].gt(0)]
    if not good.label.eq(REFERENCE).any():
        return pd.DataFrame()
    logs = np.log(good[[ERROR, RUNTIME]]).groupby([good[k] for k in ("label", *_CASE)], sort=False).mean()
    base = logs.xs(REFERENCE).reindex(logs.index.droplevel("label")).to_numpy()
    logs = (logs - base).dropna().drop(index=REFERENCE, level="label").droplevel(_CASE)
    table = _differences(logs[ERROR], "error").join(_differences(logs[RUNTIME], "time"))
    table["quality"] = _verdicts(table, "error", "worse", "better")
    table["runtime"] = _verdicts(table, "time", "slower", "faster")
    return table.sort_values("error", kind="stable")


def was_busy(run: Run) -> bool:
    """Whether other programs held a tenth of a processor, or the reference work waited a tenth of its time.

    A short call slips through between two waits and a long one does not, and what shares a processor's memory
    slows what needs it: no clock can be believed then.
    """
    frame = run.frame
    waits = frame.reference_s / frame.reference_cpu_s.where(frame.reference_cpu_s > 0)
    return bool(frame.foreign_load.median() > _LARGEST_FOREIGN_LOAD or waits.median() > 1 + _LONGEST_WAIT)


def check_inputs(first: Run, second: Run) -> None:
    """Refuse runs whose inputs differ; raises `InputError`."""
    ours, theirs = ({name: i["sha256"] for name, i in run.inputs.items()} for run in (first, second))
    different = sorted(name for name in ours.keys() & theirs.keys() if ours[name] != theirs[name])
    where = f"{first.folder} and {second.folder}"
    if different:
        names = ", ".join(different)
        raise InputError(f"{where} were run on different inputs: {names} is not the same cloud.")
    if not ours.keys() & theirs.keys():
        names = (", ".join(inputs) or "none" for inputs in (ours, theirs))
        raise InputError(f"{where} share no input: {' and '.join(names)}.")


def differing_environment(first: Run, second: Run) -> dict[str, tuple[str, str]]:
    """What of the machine and the software is not the same in both runs."""
    ours, theirs = (_facts(run.environment) for run in (first, second))
    names = [name for name in dict.fromkeys((*ours, *theirs)) if ours.get(name) != theirs.get(name)]
    return {name: (ours.get(name, "-"), theirs.get(name, "-")) for name in names}


def format_comparison(first: Run, second: Run, width: int = NARROW) -> str:
    """Differences from the first run to the second, as a table with what else is different."""
    head = ("method", "same", "runtime ratio", "", "error change", "")
    rows = [
        (plain(name), f"{r.same}/{r.n_pairs}", _ratio(r, "wall"), r.runtime, _change(r), r.quality)
        for name, r in compare_runs(first, second).iterrows()
    ]
    changed = [f"  {k}: {a} -> {b}" for k, (a, b) in differing_environment(first, second).items()]
    lines = [f"{first.folder} -> {second.folder}", *align([head, *rows], (0, 3, 5), width)]
    lines += ["", *textwrap.wrap(_legend(first, second), width)]
    if changed:
        lines += ["What else is different:", *(plain(line)[:width] for line in changed)]
    return "\n".join(lines)


def format_methods(run: Run, width: int = NARROW) -> str:
    """The methods of one run against Poisson disk; their ranks where there are models enough."""
    table = compare_methods(run)
    if table.empty:
        raise InputError(f"{run.folder} holds no results of {REFERENCE} to compare the others with.")
    head = ("method", "error ratio", "", "time ratio", "")
    rows = [
        (plain(name), _ratio(r, "error"), r.quality, _ratio(r, "time", ".2g"), r.runtime)
        for name, r in table.iterrows()
    ]
    text = (
        f"Ratios to {REFERENCE} over up to {table.error_n.max()} cases (model, perturbation, reduction, "
        "seed): geometric mean and interval. A difference is called where the interval excludes 1. The "
        "intervals are so wide that all calls together hold at 5 % (paired t on logarithms, Holm); n.s.: not "
        "significant. "
    )
    return "\n".join([*align([head, *rows], (0, 2, 4), width), "", *textwrap.wrap(text + _ranks(run), width)])


def _pairs(first: pd.DataFrame, second: pd.DataFrame) -> pd.DataFrame:
    """Rows that are ok in both runs and were asked the same, with their differences."""
    ours, theirs = (f[f.status.eq("ok")].assign(**{ERROR: f.get(ERROR, math.nan)}) for f in (first, second))
    pairs = ours.merge(theirs, on=[*_CASE, "label", "repeat"], suffixes=("", "_then"))
    logs = {
        name: _log_speed(pairs, call, work, "_then") - _log_speed(pairs, call, work, "")
        for name, call, work in (("wall", RUNTIME, "reference_s"), ("cpu", "cpu_s", "reference_cpu_s"))
    }
    return pairs[["label"]].assign(
        **logs,
        error=pairs[f"{ERROR}_then"] - pairs[ERROR],
        same=pairs.points_sha256.eq(pairs.points_sha256_then),
        seconds=pairs[[RUNTIME, f"{RUNTIME}_then"]].mean(axis=1),
    )


def _log_speed(pairs: pd.DataFrame, call: str, work: str, end: str) -> pd.Series:
    """Logarithm of the seconds of the call in units of the reference work; in seconds where there is none."""
    speed = pairs[call + end] / pairs[work + end].fillna(1.0)
    return np.log(speed.where(speed > 0))


def _differences(values: pd.Series, name: str, margin: float = 0.0) -> pd.DataFrame:
    """The paired differences of a column by its index; the columns are named after it."""
    found = paired_differences(dict(list(values.groupby(level=0, sort=False))), margin)
    return found.rename(columns=lambda column: name if column == "mean" else f"{name}_{column}")


def _verdicts(table: pd.DataFrame, name: str, more: str, less: str) -> pd.Series:
    """What the intervals allow to say; "n.s." is not significant."""
    words = table[f"{name}_sign"].map({1: more, -1: less, 0: "n.s."})
    return words.where(table[f"{name}_n"] > 1, "few pairs")


def _ratio(row: Any, name: str, form: str = ".2f") -> str:
    """A ratio with its interval; "-" where it is not known."""
    middle, low, high = (math.exp(row[f"{name}{end}"]) for end in ("", "_low", "_high"))
    if row[f"{name}_n"] < 2:
        return f"{middle:{form}}" if row[f"{name}_n"] else "-"
    return f"{middle:{form}} ({_bounded(low, form)}..{_bounded(high, form)})"


def _bounded(ratio: float, form: str) -> str:
    """The end of an interval in few characters; beyond a hundredfold its digits say nothing."""
    if 1 / 100 <= ratio <= 100:
        return f"{ratio:{form}}"
    return "<0.01" if ratio < 1 else ">100"


def _change(row: Any) -> str:
    """A difference, and how far its interval reaches to both sides."""
    if not row.error_n:
        return "-"
    return f"{row.error:+.2g}" + (f" ±{row.error_high - row.error:.2g}" if row.error_n > 1 else "")


def _ranks(run: Run) -> str:
    ranking = rank_over_models(cells(run.frame))
    if math.isnan(ranking.p_value):
        return "Ranks over models with their critical difference need at least 3 models and 3 methods."
    ranks = ", ".join(f"{plain(method)} {rank:.2f}" for method, rank in ranking.ranks.items())
    return (
        f"Mean ranks over {ranking.n_blocks} models: {ranks}. Friedman p = {ranking.p_value:.2g}; methods "
        f"differ when their ranks are more than {ranking.critical_difference:.2f} apart (Nemenyi, 5 %)."
    )


def _legend(first: Run, second: Run) -> str:
    text = (
        "same: pairs with identical points. runtime ratio: second run over first, geometric mean over the "
        "pairs and interval, by wall clock, in units of a fixed piece of work done around each call. error "
        "change: of the plane error, in % of the diagonal. A difference is called where the interval excludes "
        f"none, of runtimes where it lies beyond {100 * RUNTIME_MARGIN:g} %. All calls together hold at 5 %: "
        "the intervals are that wide (paired t, Holm); n.s.: not significant; too short: below 5 ms."
    )
    if was_busy(first) or was_busy(second):
        text += " Other programs kept the machine busy in one of the runs: no runtime is judged."
    if any(run.plan.get("jobs", 1) > 1 for run in (first, second)):
        text += " Cases ran side by side: the runtimes are unreliable."
    return text


def _facts(environment: Mapping[str, Any]) -> dict[str, str]:
    names = ("cpu", "cores_allowed", "memory_mib", "os", "python", "commit")
    nested = (environment.get(name) for name in ("packages", "threads"))
    facts = {name: environment.get(name, "-") for name in names}
    facts |= {k: v for group in nested if isinstance(group, dict) for k, v in group.items()}
    return {str(name): str(value) for name, value in facts.items()}
