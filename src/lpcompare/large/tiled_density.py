"""`lp_density` and `lp_printed` in tiles: the budgets of the whole cloud's clusters, a program per tile.

A cluster's program asks for a mean cost. In tiles, each part of the cluster is asked for its own mean, moved by
what rounding the budgets leaves, so that the parts together have the mean of the whole. Where k = 1 / PR asks
for less than any selection has, as `lp_printed` does, the budgets of the parts follow the cheapest points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.large import clusters
from lpcompare.large.clusters import count_clusters, tile_costs
from lpcompare.large.shares import largest_remainder, quotients
from lpcompare.paper.budget import allocate_budget, split_budget
from lpcompare.paper.certificate import DensityGoal
from lpcompare.paper.features import above_means
from lpcompare.paper.program import Program, SolverSettings, select
from lpcompare.paper.start import one_per_stratum
from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import Run, tile_tasks
from lpcompare.types import Indices, Mask

_BINS = 4096
_HIGHEST = 10.0
"""Logarithms of costs are counted between minus and plus this."""


def stages(job: Job, run: Run) -> None:
    """Count features and costs, share the budgets, solve."""
    clusters.stages(job, run)
    run("features", tile_tasks(job, count_features, "features"))
    job.once("budgets", share_budgets)
    run("selection", tile_tasks(job, choose, "chosen"))


def summary(job: Job) -> dict[str, Any]:
    """Z of eq. 14 of every cluster, as a share of its density, and how many programs are proven."""
    counts, budgets = job.gather("features"), job.load("budgets")
    chosen = job.sums("chosen")
    left = (counts["points"] - budgets["features"]).sum(axis=0)
    densities = (counts["costs"].sum(axis=0) - chosen["feature_costs"]) / np.maximum(left, 1)
    some = chosen["counts"] > 0
    k = left[some] / chosen["counts"][some] if job.method == "lp_printed" else 1.0
    reduced = chosen["costs"][some] / chosen["counts"][some]
    residuals = np.abs(k * reduced / densities[some] - 1)
    return {
        "largest_residual": float(residuals.max(initial=0.0)),
        "residuals": residuals,
        "n_certified": int(chosen["proven"]),
        "n_programs": int(chosen["programs"]),
    }


def count_features(job: Job, tile: int) -> None:
    """Features, other points, and sorted costs of the clusters of a tile."""
    labels, costs = tile_costs(job, tile)
    n_clusters = count_clusters(job)
    features = _features(job, tile, labels)
    keys = labels * _BINS + _bins(costs)
    job.save(
        "features",
        tile,
        features=np.bincount(labels[features], minlength=n_clusters),
        points=np.bincount(labels, minlength=n_clusters),
        costs=np.bincount(labels, costs, n_clusters),
        feature_costs=np.bincount(labels[features], costs[features], n_clusters),
        histogram=np.bincount(keys, minlength=n_clusters * _BINS).reshape(n_clusters, _BINS),
    )


def _features(job: Job, tile: int, labels: Indices) -> Mask:
    """Points more curved than the mean of their cluster, with the forgiveness of `feature_mask`."""
    return above_means(job.map_array("surface", tile)[:, 4], job.load("clusters")["curvature"], labels)


def _bins(costs: NDArray[np.float64]) -> Indices:
    places = (np.log(costs) / _HIGHEST + 1) / 2 * _BINS
    return np.clip(places, 0, _BINS - 1).astype(np.intp)


def share_budgets(job: Job) -> None:
    """Points that every part of a cluster keeps: features, and those that its program chooses."""
    counts = job.gather("features")
    sizes, n_features = counts["points"].sum(axis=0), counts["features"].sum(axis=0)
    if job.settings["retention"] == "keep-features":
        total = job.target_count * int((sizes - n_features).sum()) // int(sizes.sum())
        marked, chosen = n_features, allocate_budget(total, sizes - n_features)
    else:
        budget = allocate_budget(job.target_count, sizes)
        marked, chosen = split_budget(budget, n_features, job.settings["feature_share"])
    kept, programs = np.zeros_like(counts["points"]), np.zeros_like(counts["points"])
    for c in range(len(sizes)):
        kept[:, c] = allocate_budget(int(marked[c]), counts["features"][:, c])
        left = counts["points"][:, c] - kept[:, c]
        wanted = (
            _cheapest(job, counts["histogram"][:, c], int(chosen[c])) if job.method == "lp_printed" else left
        )
        programs[:, c] = largest_remainder(int(chosen[c]), wanted, left)
    job.save("budgets", features=kept, programs=programs)


def _cheapest(job: Job, histogram: NDArray[np.intp], total: int) -> Indices:
    """How many of the ``total`` cheapest points of a cluster each tile has."""
    ahead = np.cumsum(histogram.sum(axis=0))
    last = int(np.searchsorted(ahead, total))
    before = int(ahead[last - 1]) if last else 0
    return histogram[:, :last].sum(axis=1) + allocate_budget(total - before, histogram[:, last])


def choose(job: Job, tile: int) -> None:
    """Solve the programs of the parts of the clusters that lie in a tile."""
    labels, costs = tile_costs(job, tile)
    budgets, features = job.load("budgets"), _features(job, tile, labels)
    curvature = job.map_array("surface", tile)[:, 4]
    shifts = _shifts(job)
    generators = np.random.default_rng([job.seed, tile]).spawn(budgets["features"].shape[1])
    kept, tasks = list[Indices](), []
    for c in np.unique(labels):
        rows = np.flatnonzero(labels == c)
        marked = rows[features[rows]]
        marked = marked[np.argsort(curvature[marked], kind="stable")]
        marked = marked[one_per_stratum(len(marked), int(budgets["features"][tile, c]), generators[c])]
        rest = np.setdiff1d(rows, marked, assume_unique=True)
        kept.append(marked)
        if n_keep := int(budgets["programs"][tile, c]):
            tasks.append((c, rest, n_keep))
    programs = [_program(job, costs[rest], n_keep, float(shifts[c])) for c, rest, n_keep in tasks]
    settings = SolverSettings(job.settings["solver"], job.settings["time_limit"], job.settings["gap"])
    results = select(programs, [generators[c] for c, *_ in tasks], settings) if tasks else []
    chosen = [rest[mask] for (_, rest, _), (mask, _) in zip(tasks, results, strict=True)]
    every = np.sort(np.concatenate([*kept, *chosen, np.empty(0, dtype=np.intp)]))
    picked, marked = (np.concatenate([*some, np.empty(0, dtype=np.intp)]) for some in (chosen, kept))
    n_clusters = count_clusters(job)
    job.save_array("kept", tile, job.map_array("rows", tile)[every])
    job.save(
        "chosen",
        tile,
        counts=np.bincount(labels[picked], minlength=n_clusters),
        costs=np.bincount(labels[picked], costs[picked], n_clusters),
        feature_costs=np.bincount(labels[marked], costs[marked], n_clusters),
        proven=sum(bool(certificate.proven) for _, certificate in results),
        programs=len(results),
    )


def _program(job: Job, costs: NDArray[np.float64], n_keep: int, shift: float) -> Program:
    mean = float(costs.mean())
    k = len(costs) / n_keep if job.method == "lp_printed" else 1.0
    wanted = mean / k + shift if job.method == "lp_density" else mean / k
    return Program(costs / mean, n_keep, DensityGoal(k * wanted / mean, k))


def _shifts(job: Job) -> NDArray[np.float64]:
    """By how much the parts' own means miss that of the candidates of the whole cluster, per point chosen."""
    counts, budgets = job.gather("features"), job.load("budgets")
    mean_features = quotients(counts["feature_costs"], counts["features"])
    left = counts["points"] - budgets["features"]
    costs = counts["costs"] - budgets["features"] * mean_features
    means = quotients(costs, left)
    n_left, n_chosen = left.sum(axis=0), budgets["programs"].sum(axis=0)
    wanted = quotients(costs.sum(axis=0), n_left)
    missing = n_chosen * wanted - (budgets["programs"] * means).sum(axis=0)
    return quotients(missing, n_chosen)
