"""Stage 3 for the whole cloud: every cluster's budget, its feature points and its program."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lpcompare.paper.budget import allocate_budget, split_budget
from lpcompare.paper.certificate import Certificate, DensityGoal
from lpcompare.paper.density import cluster_density, inverse_distance_costs
from lpcompare.paper.program import Program, SolverSettings, select
from lpcompare.paper.start import one_per_stratum
from lpcompare.threads import Progress, map_in_threads
from lpcompare.types import Indices, Mask, Points, Vector


@dataclass(frozen=True, eq=False)
class ClusterTask:
    """One cluster's share of the reduction.

    Attributes
    ----------
    kept : ndarray of int, shape (f,)
        Rows of the feature points that stay.
    candidates : ndarray of int, shape (nc,)
        Rows of the points that the program chooses from.
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
class Reading:
    """How the paper's density is read.

    Attributes
    ----------
    method : {"lp_density", "lp_printed"}
        k = 1, or k = 1 / PR with PR = nr / nc.
    density : {"mean", "printed"}
        D_c as the text says it, or as eq. 12 prints it.
    scale : float
        Model units per unit of the points; it matters for the printed eq. 12 alone.
    """

    method: str = "lp_density"
    density: str = "mean"
    scale: float = 1.0

    def goal(self, costs: Vector, n_keep: int, mean_cost: float) -> DensityGoal:
        """Eqs. 12 and 14 for one cluster; ``costs`` and ``mean_cost`` as `inverse_distance_costs` returns."""
        k = len(costs) / n_keep if self.method == "lp_printed" and n_keep else 1.0
        return DensityGoal(cluster_density(costs, mean_cost / self.scale, self.density), k)


def plan_clusters(
    points: Points,
    labels: Indices,
    features: Mask,
    curvature: Vector,
    *,
    target_count: int,
    rng: np.random.Generator,
    retention: str = "exact-count",
    feature_share: float = 0.4,
) -> list[ClusterTask]:
    """Share the target among the clusters and decide which feature points stay.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    labels : ndarray of int, shape (n,)
    features : ndarray of bool, shape (n,)
    curvature : ndarray, shape (n,)
        Absolute curvature; where not all features can stay, those that do are spread evenly over it.
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        One generator per cluster is drawn from it.
    retention : {"exact-count", "keep-features"}
        "exact-count": ``target_count`` points stay. Features come first up to a share; those beyond it are
        candidates of the program like any other point. "keep-features": all features stay and the rest is
        reduced by the rate, as the paper says.
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
        n_kept, n_chosen = n_features, allocate_budget(total, n_others)
    else:
        n_kept, n_chosen = split_budget(allocate_budget(target_count, sizes), n_features, feature_share)
    generators = rng.spawn(len(sizes))
    members = np.split(np.argsort(labels, kind="stable"), np.cumsum(sizes)[:-1])
    tasks = []
    for rows, n_marked, n_program, generator in zip(members, n_kept, n_chosen, generators, strict=True):
        if len(rows):
            marked = rows[features[rows]]
            marked = marked[np.argsort(curvature[marked], kind="stable")]
            kept = marked[one_per_stratum(len(marked), int(n_marked), generator)]
            candidates = np.setdiff1d(rows, kept, assume_unique=True)
            centroid = points[rows].mean(axis=0)
            tasks.append(ClusterTask(kept, candidates, int(n_program), centroid, generator))
    return tasks


def reduce_clusters(
    points: Points,
    tasks: list[ClusterTask],
    reading: Reading,
    settings: SolverSettings,
    progress: Progress | None = None,
) -> tuple[Indices, list[Certificate]]:
    """Solve every cluster's program, in parallel threads.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Normalised cloud.
    tasks : list of ClusterTask
    reading : Reading
    settings : SolverSettings
    progress : callable, optional
        Called with (clusters done, clusters).

    Returns
    -------
    indices : ndarray of int, shape (m,)
        Rows that stay, ascending.
    certificates : list of Certificate
        One per task, densities in 1 / model units.
    """
    priced = map_in_threads(
        lambda task: inverse_distance_costs(points[task.candidates], task.centroid), tasks
    )
    programs = [
        Program(costs, task.n_keep, reading.goal(costs, task.n_keep, mean_cost))
        for task, (costs, mean_cost) in zip(tasks, priced, strict=True)
    ]
    results = select(programs, [task.rng for task in tasks], settings, progress)
    chosen = [task.candidates[mask] for task, (mask, _) in zip(tasks, results, strict=True)]
    kept = np.concatenate(chosen + [task.kept for task in tasks])
    certificates = [
        certificate.in_units(mean_cost / reading.scale)
        for (_, certificate), (_, mean_cost) in zip(results, priced, strict=True)
    ]
    return np.sort(kept), certificates
