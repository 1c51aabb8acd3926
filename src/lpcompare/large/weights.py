"""The weights that decide the local density of `lp_uniform`, and the budgets of tiles that follow from them.

A power of the cost tilts the weights of each cluster so that their mean cost is the cluster's density. A sample
gives the powers nearly, and one step of Newton's method with the sums of all points makes them exact enough.
"""

from __future__ import annotations

import numpy as np

from lpcompare.large.clusters import count_clusters, surface_of, tile_costs
from lpcompare.large.shares import largest_remainder, quotients
from lpcompare.large.spacing import disk_counts, radius_of, trial_radii
from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import Run, normalized, tile_tasks, uniform
from lpcompare.types import Vector
from lpcompare.uniform.cells import tilt_powers, weights_in

_SAMPLE = 250_000


def stages(job: Job, run: Run) -> None:
    """Powers from a sample, powers from all points, budgets."""
    run("weights", tile_tasks(job, sample, "weight_sample"))
    job.once("powers", _find_powers)
    run("tilts", tile_tasks(job, sum_tilted, "tilted"))
    job.once("tilts", _correct_powers)
    run("budgets", tile_tasks(job, sum_weights, "weight_sums"))
    job.once("budgets", _share_budgets)


def weighted(job: Job, tile: int) -> Vector:
    """The weights of the points of a tile, up to a factor of the whole cloud."""
    labels, costs = tile_costs(job, tile)
    tilted = costs ** job.load("tilts")["powers"][labels] * job.load("budgets")["factors"][labels]
    return _untilted(job, tile) * tilted


def sample(job: Job, tile: int) -> None:
    """Weights and costs of a seeded sample of a tile, and the sums of all weights of its clusters."""
    rows = np.asarray(job.map_array("rows", tile))
    drawn = uniform(rows, job.seed + 2) < _SAMPLE / job.n_points
    labels, costs = tile_costs(job, tile)
    weights = _untilted(job, tile)
    sums = np.bincount(labels, weights, count_clusters(job))
    job.save(
        "weight_sample", tile, weights=weights[drawn], labels=labels[drawn], costs=costs[drawn], sums=sums
    )


def _untilted(job: Job, tile: int) -> Vector:
    whole = job.load("clusters")
    surface, curvature = surface_of(job.map_array("surface", tile))
    return weights_in(surface.areas, curvature, float(whole["mean_curvature"]), float(whole["smallest_area"]))


def _find_powers(job: Job) -> None:
    parts = [job.load("weight_sample", tile) for tile in range(job.n_tiles)]
    weights, labels, costs = (np.concatenate([p[n] for p in parts]) for n in ("weights", "labels", "costs"))
    powers = tilt_powers(weights, costs, labels, count_clusters(job))
    job.save("powers", powers=powers, sums=np.sum([p["sums"] for p in parts], axis=0), radii=trial_radii(job))


def sum_tilted(job: Job, tile: int) -> None:
    """What the clusters of a tile have too much of their density, and its slope over the power."""
    labels, costs = tile_costs(job, tile)
    tilted = _untilted(job, tile) * costs ** job.load("powers")["powers"][labels] * (costs - 1.0)
    n_clusters = count_clusters(job)
    slopes = np.bincount(labels, tilted * np.log(costs), n_clusters)
    job.save("tilted", tile, excess=np.bincount(labels, tilted, n_clusters), slopes=slopes)


def _correct_powers(job: Job) -> None:
    sums = job.sums("tilted")
    steps = quotients(sums["excess"], sums["slopes"])
    job.save("tilts", powers=job.load("powers")["powers"] - np.clip(steps, -0.5, 0.5))


def sum_weights(job: Job, tile: int) -> None:
    """Tilted weights and weighted costs of the clusters of a tile, and disks that it would take."""
    labels, costs = tile_costs(job, tile)
    weights = _untilted(job, tile) * costs ** job.load("tilts")["powers"][labels]
    points = normalized(job, job.map_array("points", tile))
    job.save(
        "weight_sums",
        tile,
        weights=np.bincount(labels, weights, count_clusters(job)),
        costs=np.bincount(labels, weights * costs, count_clusters(job)),
        points=len(labels),
        disks=disk_counts(points, job.load("powers")["radii"], job.target_count / job.n_points),
    )


def _share_budgets(job: Job) -> None:
    """Points of every tile, what each part of a cluster should have, and the radius of the hole limit."""
    sums = job.gather("weight_sums")
    tilted = sums["weights"].sum(axis=0)
    factors = quotients(job.load("powers")["sums"], tilted, 1.0)
    weights = sums["weights"] * factors
    totals = weights.sum(axis=1)
    budgets = largest_remainder(job.target_count, totals, sums["points"])
    means = quotients(sums["costs"], sums["weights"], 1.0)
    shares = quotients(weights, totals[:, None])
    radius = radius_of(job.target_count, job.load("powers")["radii"], sums["disks"].sum(axis=0))
    counts = budgets[:, None] * shares
    job.save("budgets", budgets=budgets, means=means, counts=counts, factors=factors, radius=radius)
