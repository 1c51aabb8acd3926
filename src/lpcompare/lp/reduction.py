"""Stage 3 for the whole cloud: every cluster's budget, its feature points and its programme."""

from __future__ import annotations

from dataclasses import dataclass
from threading import Event

import numpy as np

from lpcompare.geometry.threads import Progress, map_in_threads
from lpcompare.lp.budget import allocate_budget, split_budget
from lpcompare.lp.density import cluster_density, inverse_distance_costs
from lpcompare.lp.selection import Certificate, select
from lpcompare.types import Indices, Mask, Points, Vector


@dataclass(frozen=True, eq=False)
class ClusterTask:
    """One cluster's share of the reduction.

    Attributes
    ----------
    kept : ndarray of int, shape (f,)
        Rows of the feature points that stay.
    candidates : ndarray of int, shape (nc,)
        Rows of the points that the programme chooses from.
    n_keep : int
        How many it chooses (nr).
    centroid : ndarray, shape (3,)
        Mean of all points of the cluster.
    rng : numpy.random.Generator
        The cluster's own, so that the order of the threads does not matter.
    """

    kept: Indices
    candidates: Indices
    n_keep: int
    centroid: Vector
    rng: np.random.Generator


@dataclass(frozen=True)
class Programme:
    """How the programme of a cluster is stated and solved; the fields are the settings of `simplify`."""

    method: str = "lp_density"
    density: str = "mean"
    solver: str = "highs"
    time_limit: float = 10.0
    gap: float = 0.0


def plan_clusters(
    points: Points,
    labels: Indices,
    features: Mask,
    curvature: Vector,
    target_count: int,
    rng: np.random.Generator,
    *,
    retention: str = "exact-count",
    feature_share: float = 0.5,
) -> list[ClusterTask]:
    """Share the target among the clusters and decide which feature points stay.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    labels : ndarray of int, shape (n,)
    features : ndarray of bool, shape (n,)
    curvature : ndarray, shape (n,)
        Absolute curvature; where not all features can stay, the most curved do.
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        One generator per cluster is drawn from it.
    retention : {"exact-count", "keep-features"}
        "exact-count": ``target_count`` points stay, features among them up to a share. "keep-features": all
        features stay and the rest is reduced by the rate, as the paper says.
    feature_share : float
        Largest share of a cluster's budget that features take under "exact-count".

    Returns
    -------
    list of ClusterTask
        One per cluster that owns a point, by label.
    """
    sizes = np.bincount(labels)
    n_features = np.bincount(labels, features, minlength=len(sizes)).astype(np.intp)
    n_others = sizes - n_features
    if retention == "keep-features":
        total = target_count * int(n_others.sum()) // len(labels)
        splits = list(zip(n_features, allocate_budget(total, n_others), strict=True))
    else:
        budget = allocate_budget(target_count, sizes)
        splits = [split_budget(*c, feature_share) for c in zip(budget, n_features, n_others, strict=True)]
    generators = rng.spawn(len(sizes))
    members = np.split(np.argsort(labels, kind="stable"), np.cumsum(sizes)[:-1])
    return [
        _task(points, rows, features, curvature, split, generator)
        for rows, split, generator in zip(members, splits, generators, strict=True)
        if len(rows)
    ]


def _task(
    points: Points,
    rows: Indices,
    features: Mask,
    curvature: Vector,
    split: tuple[int, int],
    rng: np.random.Generator,
) -> ClusterTask:
    marked, others = rows[features[rows]], rows[~features[rows]]
    most_curved = marked[np.argsort(-curvature[marked], kind="stable")[: split[0]]]
    return ClusterTask(np.sort(most_curved), others, int(split[1]), points[rows].mean(axis=0), rng)


def reduce_clusters(
    points: Points,
    tasks: list[ClusterTask],
    programme: Programme,
    *,
    scale: float = 1.0,
    progress: Progress | None = None,
) -> tuple[Indices, list[Certificate]]:
    """Solve every cluster's programme, in parallel threads.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Normalised cloud.
    tasks : list of ClusterTask
    programme : Programme
    scale : float
        Model units per unit of ``points``; it matters for the printed eq. 12 alone.
    progress : callable, optional
        Called with (clusters done, clusters).

    Returns
    -------
    indices : ndarray of int, shape (m,)
        Rows that stay, ascending.
    certificates : list of Certificate
        One per task, densities in 1 / model units.
    """
    cancelled = Event()

    def solve(task: ClusterTask) -> tuple[Indices, Certificate]:
        return _solve(points, task, programme, scale, cancelled)

    results = map_in_threads(solve, tasks, progress, cancelled)
    chosen = [rows for rows, _ in results] + [task.kept for task in tasks]
    return np.sort(np.concatenate(chosen)), [certificate for _, certificate in results]


def _solve(
    points: Points, task: ClusterTask, programme: Programme, scale: float, cancelled: Event
) -> tuple[Indices, Certificate]:
    costs, mean_cost = inverse_distance_costs(points[task.candidates], task.centroid)
    mask, certificate = select(
        costs,
        task.n_keep,
        density=cluster_density(costs, mean_cost / scale, programme.density),
        k=len(costs) / task.n_keep if programme.method == "lp_printed" and task.n_keep else 1.0,
        rng=task.rng,
        solver=programme.solver,
        time_limit=programme.time_limit,
        gap=programme.gap,
        cancelled=cancelled,
    )
    return task.candidates[mask], certificate.in_units(mean_cost / scale)
