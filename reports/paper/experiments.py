"""The measurements behind the reproduction: what is run, over which cases, and what a row holds.

Each experiment fills one CSV file. Its cases are known beforehand: a stopped command goes on with the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from reports.paper.holes import describe_holes
from reports.paper.lab import Lab
from reports.paper.table import Row

from lpcompare import LPSimplifier, evaluate, simplify
from lpcompare.benchmark.perturbation import Perturbation, perturb
from lpcompare.types import Points

REDUCTIONS = (0.7, 0.8, 0.9)
TABLE_CLUSTERS = (15, 20, 25)
CURVE_CLUSTERS = (10, 15, 20, 25, 30, 35)
READINGS = ("lp_printed", "lp_density")
RETENTIONS = ("keep-features", "exact-count")
TIMED_REPEATS = 3
COUNT_SEEDS = 10
CURVE_SEEDS = 3
PICTURED_CLUSTERS = 20
COMPARED = ("lp_printed", "lp_density", "lp_uniform", "random_sample")
UNITS = (2.0**-12, 2.0**-6, 2.0**6, 2.0**11)
NOISE = (0.25, 0.5, 1.0)
OUTLIERS = (0.01, 0.02, 0.05)


@dataclass(frozen=True)
class Experiment:
    """One CSV file of the reproduction.

    Attributes
    ----------
    name : str
        The file's stem.
    title : str
        What is measured, for progress and the page.
    keys : tuple of str
        The columns that name a case.
    cases : callable
        Model names to cases.
    measure : callable
        A case to the measured columns.
    """

    name: str
    title: str
    keys: tuple[str, ...]
    cases: Callable[[tuple[str, ...]], Iterator[Row]]
    measure: Callable[[Lab, Row], Row]


def plane_errors_pct(original: Points, simplified: Points) -> dict[str, float]:
    """Eq. 27 for 6, 8 and 12 neighbors, in % of the bounding-box diagonal."""
    values = evaluate(original, simplified, metrics=("plane_error",))
    columns = {6: "plane_error_k6_pct", 8: "plane_error_pct", 12: "plane_error_k12_pct"}
    return {f"plane_error_k{k}_pct": values[column] for k, column in columns.items()}


def kept_count(n_points: int, reduction: float) -> int:
    """Points kept: floor((1 - reduction) n), rounded to nine digits first."""
    return max(1, int(np.floor(round((1.0 - reduction) * n_points, 9))))


def _grid(**axes: Any) -> Callable[[tuple[str, ...]], Iterator[Row]]:
    def cases(models: tuple[str, ...]) -> Iterator[Row]:
        for values in product(models, *axes.values()):
            yield dict(zip(("model", *axes), values, strict=True))

    return cases


def _seconds(lab: Lab, case: Row) -> Row:
    """Table I: seconds of each stage; the estimator is not cached, since the call is what is timed."""
    simplifier = LPSimplifier(
        target_reduction=case["reduction"],
        method="lp_printed",
        n_clusters=case["n_clusters"],
        retention="keep-features",
        random_state=case["repeat"],
    ).fit(lab.points(case["model"]))
    stages = simplifier.timings_
    return {
        "normals_s": stages["curvature"],
        "clustering_s": stages["clustering"],
        "selection_s": stages["selection"],
    }


def _count(lab: Lab, case: Row) -> Row:
    """Points that stay when every feature point is kept; eq. 22's nr for the others."""
    simplifier = LPSimplifier(
        target_reduction=REDUCTIONS[0],
        method="lp_printed",
        retention="keep-features",
        n_clusters=case["n_clusters"],
        random_state=case["seed"],
    ).fit(lab.points(case["model"]))
    n, features = len(simplifier.labels_), int(simplifier.feature_mask_.sum())
    kept = {f"kept_{r:g}": features + kept_count(n - features, r) for r in REDUCTIONS}
    return {"n_points": n, "n_features": features, "n_output": len(simplifier.sample_indices_), **kept}


def _error(lab: Lab, case: Row) -> Row:
    simplifier = lab.fitted(
        case["model"],
        case["reading"],
        case["retention"],
        case["n_clusters"],
        case["reduction"],
        case["seed"],
    )
    points = lab.points(case["model"])
    kept = simplifier.simplification_.points
    return {"n_output": len(kept), **plane_errors_pct(points, kept)}


def _program(lab: Lab, case: Row) -> Row:
    """What the optimum of each cluster is, and what rescaling the model does to it."""
    points = lab.points(case["model"])
    settings: dict[str, Any] = {
        "target_reduction": case["reduction"],
        "method": case["reading"],
        "density": case["density"],
        "retention": "exact-count",
        "feature_share": 0.0,
        "random_state": 0,
    }
    simplifier = LPSimplifier(**settings).fit(points)
    rescaled = [LPSimplifier(**settings).fit(unit * points).sample_indices_ for unit in UNITS]
    same = min(np.intersect1d(simplifier.sample_indices_, other).size for other in rescaled)
    certificates = simplifier.certificates_
    return {
        "clusters": len(certificates),
        "farthest_chosen": _clusters_that_kept_the_farthest(points, simplifier),
        "proven": sum(c.proven for c in certificates),
        "largest_residual": max(c.residual for c in certificates),
        "same_after_rescaling_pct": 100.0 * same / len(simplifier.sample_indices_),
    }


def _clusters_that_kept_the_farthest(points: Points, simplifier: LPSimplifier) -> int:
    """Clusters in which every kept point is at least as far from the centroid as every removed one."""
    kept = np.zeros(len(points), dtype=bool)
    kept[simplifier.sample_indices_] = True
    chosen = 0
    for label in np.unique(simplifier.labels_):
        rows = np.flatnonzero((simplifier.labels_ == label) & ~simplifier.feature_mask_)
        centroid = points[simplifier.labels_ == label].mean(axis=0)
        distances = np.linalg.norm(points[rows] - centroid, axis=1)
        inside, outside = distances[kept[rows]], distances[~kept[rows]]
        chosen += bool(inside.size and outside.size and inside.min() >= outside.max() * (1 - 1e-9))
    return chosen


def _holes(lab: Lab, case: Row) -> Row:
    points = lab.points(case["model"])
    target = kept_count(len(points), case["reduction"])
    labels = lab.fitted(
        case["model"], "lp_density", "exact-count", PICTURED_CLUSTERS, case["reduction"], 0
    ).labels_
    kept = simplify(points, target_count=target, method=case["method"], random_state=0).points
    return describe_holes(points, kept, labels)


def _features(lab: Lab, case: Row) -> Row:
    points = lab.points(case["model"])
    simplifier = LPSimplifier(
        target_reduction=case["reduction"],
        method="lp_density",
        feature_share=case["feature_share"],
        random_state=0,
    ).fit(points)
    kept = simplifier.simplification_
    return {"n_features_kept": kept.info["n_features_kept"], **plane_errors_pct(points, kept.points)}


def _robustness(lab: Lab, case: Row) -> Row:
    """Error against the clean cloud; every method is given the count of the clean cloud."""
    cloud, seed = lab.clouds[case["model"]], case["seed"]
    damaged = perturb(cloud, Perturbation(case["kind"], case["level"]), seed)
    target = kept_count(len(cloud), case["reduction"])
    kept = simplify(damaged.points, target_count=target, method=case["method"], random_state=seed).points
    return plane_errors_pct(cloud.points, kept)


def _damaged_cases(models: tuple[str, ...]) -> Iterator[Row]:
    damages = [("none", 0.0), *(("noise", v) for v in NOISE), *(("outliers", v) for v in OUTLIERS)]
    for model, (kind, level), method, seed in product(models, damages, COMPARED, range(CURVE_SEEDS)):
        yield {
            "model": model,
            "method": method,
            "kind": kind,
            "level": level,
            "reduction": REDUCTIONS[1],
            "seed": seed,
        }


EXPERIMENTS = (
    Experiment(
        "seconds",
        "Table I: seconds per stage",
        ("model", "n_clusters", "reduction", "repeat"),
        _grid(n_clusters=TABLE_CLUSTERS, reduction=REDUCTIONS, repeat=range(TIMED_REPEATS)),
        _seconds,
    ),
    Experiment(
        "counts",
        "Points that stay when all feature points are kept",
        ("model", "n_clusters", "seed"),
        _grid(n_clusters=TABLE_CLUSTERS, seed=range(COUNT_SEEDS)),
        _count,
    ),
    Experiment(
        "errors",
        "Fig. 9: eq. 27 error against the number of clusters",
        ("model", "n_clusters", "seed", "reading", "retention", "reduction"),
        _grid(
            n_clusters=CURVE_CLUSTERS,
            seed=range(CURVE_SEEDS),
            reading=READINGS,
            retention=RETENTIONS,
            reduction=REDUCTIONS,
        ),
        _error,
    ),
    Experiment(
        "program",
        "What the program's optimum is",
        ("model", "reading", "density", "reduction"),
        _grid(reading=READINGS, density=("mean", "printed"), reduction=REDUCTIONS),
        _program,
    ),
    Experiment(
        "holes",
        "Holes: distance of the originals to the nearest kept point",
        ("model", "method", "reduction"),
        _grid(method=COMPARED, reduction=REDUCTIONS),
        _holes,
    ),
    Experiment(
        "features",
        "What the feature rule does at each rate",
        ("model", "feature_share", "reduction"),
        _grid(feature_share=(0.0, 0.25, 0.5, 0.75, 1.0), reduction=REDUCTIONS),
        _features,
    ),
    Experiment(
        "robustness",
        "Error against the clean cloud under noise and outliers",
        ("model", "method", "kind", "level", "reduction", "seed"),
        _damaged_cases,
        _robustness,
    ),
)
