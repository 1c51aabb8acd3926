"""The paper's statements held against the measurements: one function per statement.

A function is given the tables and a model's name, and returns None where they say nothing about that model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from reports.paper.published import counterpart
from reports.paper.rows import Rows, distinct, span, values, where
from scipy.stats import spearmanr

Tables = Mapping[str, Rows]


@dataclass(frozen=True)
class Finding:
    """One statement and what became of it.

    Attributes
    ----------
    statement : str
        What the paper says, shortened.
    verdict : str
        "confirmed", "not confirmed", "refuted" or "cannot be right".
    evidence : str
        The numbers.
    file : str
        The table that they come from.
    """

    statement: str
    verdict: str
    evidence: str
    file: str


def density_definition(tables: Tables, model: str) -> Finding | None:
    """Eq. 12 against its own sentence and eq. 15."""
    rows = where(tables["program"], model=model, reading="lp_density")
    if not rows:
        return None
    printed = values(rows, "same_after_rescaling_pct", density="printed")
    mean = values(rows, "same_after_rescaling_pct", density="mean")
    return Finding(
        "Eq. 12 is the cluster's density, the average of the inverse distance.",
        "cannot be right" if printed.min() < mean.min() else "confirmed",
        "Eq. 12 prints 1 / sum(1/d), a length, where its sentence and eq. 15 say mean(1/d). Changing the"
        f" unit of the model leaves at least {mean.min():.0f} % of the selection as it was with the mean, and"
        f" as little as {printed.min():.0f} % with eq. 12 as printed.",
        "program.csv",
    )


def proportionality(tables: Tables, model: str) -> Finding | None:
    """K = 1/PR of eq. 14, both densities averaged."""
    rows = where(tables["program"], model=model, density="mean", reading="lp_printed")
    if not rows:
        return None
    farthest, clusters = values(rows, "farthest_chosen").sum(), values(rows, "clusters").sum()
    return Finding(
        "With k = 1/PR the program finds a subset of proportional density (eqs. 14-20).",
        "refuted" if farthest == clusters else "not confirmed",
        f"In {farthest:.0f} of {clusters:.0f} clusters over the three rates the proven optimum is the nr"
        f" points farthest from the centroid; the largest Z is {values(rows, 'largest_residual').max():.2f}"
        " of the cluster's density."
        " No subset reaches the target, so rims survive and centres empty.",
        "program.csv",
    )


def density_kept(tables: Tables, model: str) -> Finding | None:
    """The usable reading: the subset keeps the mean inverse distance."""
    rows = where(tables["program"], model=model, density="mean", reading="lp_density")
    if not rows:
        return None
    proven, clusters = values(rows, "proven").sum(), values(rows, "clusters").sum()
    return Finding(
        "The reduced set has a density equivalent to the original's.",
        "confirmed" if proven == clusters else "not confirmed",
        f"Read as k = 1 (`lp_density`), {proven:.0f} of {clusters:.0f} clusters are proven optimal over the"
        f" three rates, with Z at most {values(rows, 'largest_residual').max():.1e} of the density.",
        "program.csv",
    )


def count_with_features(tables: Tables, model: str) -> Finding | None:
    """20,130 points at 70 %."""
    rows, paper = where(tables["counts"], model=model), counterpart(model)
    if not rows or paper is None or "kept_with_features" not in paper:
        return None
    claimed = paper["kept_with_features"]
    parts, worst = [], 0.0
    for k in distinct(rows, "n_clusters"):
        counts = values(rows, "n_output", n_clusters=k)
        worst = max(worst, float(np.abs(counts / claimed - 1).max()))
        parts.append(f"K = {k}: {counts.mean():,.0f} (from {counts.min():,.0f} to {counts.max():,.0f})")
    seeds = len(distinct(rows, "seed"))
    return Finding(
        f"At 70 % the feature points and the reduced rest are {claimed:,} points.",
        "confirmed" if worst <= 0.01 else "not confirmed",
        f"Over {seeds} seeds, {'; '.join(parts)}. The farthest is {100 * worst:.2f} % off.",
        "counts.csv",
    )


def impossible_counts(tables: Tables, model: str) -> Finding | None:
    """7,189 and 3,594 points although no feature point is removed."""
    rows, paper = where(tables["counts"], model=model), counterpart(model)
    if not rows or paper is None or int(rows[0]["n_points"]) != paper["points"]:
        return None
    features, kept = values(rows, "n_features"), paper["kept"]
    below = [f"{kept[r]:,} at {float(r):.0%}" for r in kept if kept[r] < features.min()]
    if not below:
        return None
    return Finding(
        f"No feature point is removed, and {', '.join(below)} remain.",
        "cannot be right",
        f"The feature points alone are {span(features, ',.0f')}; keeping them all leaves"
        f" {span(values(rows, 'kept_0.8'), ',.0f')} points at 80 % and"
        f" {span(values(rows, 'kept_0.9'), ',.0f')} at 90 %.",
        "counts.csv",
    )


def printed_rate(tables: Tables, model: str) -> Finding | None:
    """Sizes that are not the rate named beside them (Max Planck at 70 %)."""
    paper = counterpart(model)
    if paper is None or not where(tables["counts"], model=model):
        return None
    wrong = {
        r: kept for r, kept in paper["kept"].items() if abs(kept / paper["points"] - (1 - float(r))) > 0.01
    }
    if not wrong:
        return None
    told = "; ".join(f"{k:,} at {float(r):.0%} is {k / paper['points']:.0%} kept" for r, k in wrong.items())
    return Finding(
        f"{paper['title']}: the sizes belong to reductions of 70, 80 and 90 %.",
        "cannot be right",
        f"Of {paper['points']:,} points, {told}.",
        "published.toml",
    )


def more_clusters(tables: Tables, model: str) -> Finding | None:
    """Fig. 9: the error tends to decrease when the number of clusters increases."""
    rows = where(tables["errors"], model=model)
    if not rows:
        return None
    falling, rising, curves = 0, 0, 0
    for key in sorted({(r["reading"], r["retention"], r["reduction"]) for r in rows}):
        curve = where(rows, **dict(zip(("reading", "retention", "reduction"), key, strict=True)))
        curves += 1
        errors = values(curve, "plane_error_k8_pct")
        if np.allclose(errors, errors[0]):
            continue
        rho, p = map(float, spearmanr(values(curve, "n_clusters"), errors))
        falling += bool(p < 0.05 and rho < 0)
        rising += bool(p < 0.05 and rho > 0)
    ratios = _end_ratio(rows)
    return Finding(
        "The error tends to decrease when the number of clusters increases.",
        "confirmed" if falling > curves / 2 else "not confirmed",
        f"Of {curves} curves (reading, retention, rate) {falling} fall and {rising} rise with K (Spearman,"
        f" p < 0.05); the error at the largest K is {span(ratios, '.2f')} of that at the smallest.",
        "errors.csv",
    )


def _end_ratio(rows: Rows) -> list[float]:
    """Mean error at the largest K over that at the smallest, per curve."""
    first, *_, last = sorted(distinct(rows, "n_clusters"), key=int)
    keys = sorted({(r["reading"], r["retention"], r["reduction"]) for r in rows})
    ends = []
    for key in keys:
        curve = where(rows, **dict(zip(("reading", "retention", "reduction"), key, strict=True)))
        low, high = (values(curve, "plane_error_k8_pct", n_clusters=k).mean() for k in (first, last))
        ends.append(float(high / low))
    return ends


def higher_rate(tables: Tables, model: str) -> Finding | None:
    """Fig. 9: the error grows with the reduction rate."""
    rows = where(tables["errors"], model=model)
    if not rows:
        return None
    growing, triples = 0, 0
    for key in sorted({(r["reading"], r["retention"], r["n_clusters"], r["seed"]) for r in rows}):
        names = ("reading", "retention", "n_clusters", "seed")
        triple = sorted(
            where(rows, **dict(zip(names, key, strict=True))), key=lambda r: float(r["reduction"])
        )
        growing += bool((np.diff(values(triple, "plane_error_k8_pct")) > 0).all())
        triples += 1
    return Finding(
        "The error decreases when the reduction rate decreases.",
        "confirmed" if growing == triples else "not confirmed",
        f"{growing} of {triples} runs grow from 70 over 80 to 90 %.",
        "errors.csv",
    )


def robustness(tables: Tables, model: str) -> Finding | None:
    """Robust to noise and outliers: held against a random choice, which looks at nothing."""
    rows = where(tables["robustness"], model=model)
    if not rows:
        return None
    methods = distinct(rows, "method")
    clean = _errors_of(rows, methods, kind="none")
    parts, worse, judged = [], 0, 0
    for kind in ("noise", "outliers"):
        level = max(values(rows, "level", kind=kind))
        damaged = _errors_of(rows, methods, kind=kind, level=level)
        grown = {m: damaged[m] - clean[m] for m in methods}
        told = (f"{m} {clean[m]:.3f} to {damaged[m]:.3f}" for m in methods)
        parts.append(f"{kind} {level:g}: {', '.join(told)}")
        for reading in ("lp_printed", "lp_density"):
            worse += grown[reading] > grown["random_sample"]
            judged += 1
    return Finding(
        "The approach is robust to noise and outliers.",
        "refuted" if worse == judged else "not confirmed" if worse else "confirmed",
        "Error against the clean cloud, from the undamaged to the damaged input, in % of the diagonal;"
        f" {'; '.join(parts)}. In {worse} of {judged} comparisons the paper's method loses more than a random"
        " choice does.",
        "robustness.csv",
    )


def _errors_of(rows: Rows, methods: list[str], **damage: object) -> dict[str, float]:
    """Mean error of each method under one damage."""
    return {m: float(values(rows, "plane_error_k8_pct", method=m, **damage).mean()) for m in methods}


def feature_rule(tables: Tables, model: str) -> Finding | None:
    """Keeping high-curvature points guarantees that the features survive, also at 80 and 90 %."""
    rows = where(tables["features"], model=model)
    if not rows:
        return None
    parts, all_features, some_features = [], 0, 0
    for rate in distinct(rows, "reduction"):
        best = min(where(rows, reduction=rate), key=lambda r: float(r["plane_error_k8_pct"]))
        without = values(rows, "plane_error_k8_pct", reduction=rate, feature_share=0.0)[0]
        full = values(rows, "plane_error_k8_pct", reduction=rate, feature_share=1.0)[0]
        all_features += full < without
        some_features += float(best["feature_share"]) > 0
        parts.append(
            f"at {float(rate):.0%}: {without:.4f} without features, {full:.4f} with features first, least"
            f" {float(best['plane_error_k8_pct']):.4f} at a share of {float(best['feature_share']):.0%}"
        )
    verdicts = {all_features == len(parts): "confirmed", not some_features: "refuted"}
    return Finding(
        "Keeping the points of high curvature preserves the geometry, even at 80 and 90 %.",
        verdicts.get(True, "not confirmed"),
        "Eq. 27 error in % of the diagonal at equal counts, " + "; ".join(parts) + ".",
        "features.csv",
    )


def holes(tables: Tables, model: str) -> Finding | None:
    """Discontinuities at 80 and 90 % lie over planar regions."""
    rows = where(tables["holes"], model=model)
    if not rows:
        return None
    rate = max(distinct(rows, "reduction"), key=float)
    at = {r["method"]: r for r in where(rows, reduction=rate)}
    told = "; ".join(
        f"{m} {float(r['gap_max_pct']):.2f} % ({float(r['wide_gap_pct']):.1f} % of the points uncovered)"
        for m, r in at.items()
    )
    central = float(at["lp_printed"]["central_pct"])
    return Finding(
        "At 80 and 90 % holes appear, over planar regions.",
        "confirmed" if central <= 60 else "not confirmed",
        f"Largest distance of an original to a kept point at {float(rate):.0%}, in % of the diagonal: {told}."
        f" Of the printed program's worst-covered points {central:.0f} % lie in the inner half of their"
        " cluster (50 % if holes did not care about centroids).",
        "holes.csv",
    )


def costliest_stage(tables: Tables, model: str) -> Finding | None:
    """Table I: clustering is the most expensive stage."""
    rows = where(tables["seconds"], model=model)
    if not rows:
        return None
    stages = {s: values(rows, f"{s}_s").mean() for s in ("normals", "clustering", "selection")}
    total = sum(stages.values())
    told = ", ".join(f"{s} {100 * t / total:.0f} %" for s, t in stages.items())
    return Finding(
        "Clustering is the most expensive stage.",
        "confirmed" if max(stages, key=lambda s: stages[s]) == "clustering" else "not confirmed",
        f"Mean shares of the time: {told}.",
        "seconds.csv",
    )


STATEMENTS = (
    density_definition,
    proportionality,
    density_kept,
    count_with_features,
    impossible_counts,
    printed_rate,
    more_clusters,
    higher_rate,
    feature_rule,
    holes,
    robustness,
    costliest_stage,
)


def audit(tables: Tables, model: str) -> list[Finding]:
    """Every statement that the tables can judge for one model."""
    return [finding for judge in STATEMENTS if (finding := judge(tables, model)) is not None]
