"""`lp_uniform` in tiles: cells and swaps per tile, kept points of neighbouring tiles seen by both.

1. The weights that decide local density are those of the whole cloud; a tile's budget is its share of them.
2. Every tile spreads its budget over its own points, as cells, without regard to its neighbours.
3. Swaps see the kept points around a tile and do not move them. Tiles that touch have different colours and take
   turns, so that the later one sees what the earlier one kept, and each seam is worked on from both sides.
4. Each part of a cluster has a program, with the kept points around it as sites of other cells.

Each part of a cluster keeps the sum of costs that the weights foresee for it, so that the whole keeps its density.
Small parts miss it in the swaps; the programs then aim at what brings the whole back into its band.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface
from lpcompare.large import clusters, weights
from lpcompare.large.clusters import count_clusters, surface_of, surroundings, tile_costs
from lpcompare.large.shares import quotients
from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import (
    Around,
    Run,
    distances_to_box,
    save_turns,
    take,
    tile_tasks,
    tiles_before,
)
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare.uniform.clusters import BAND, ClusterDensity, best_of_cells, solve_programs
from lpcompare.uniform.densities import DensityBand
from lpcompare.uniform.program import Stop
from lpcompare.uniform.rims import Rims, find_rims
from lpcompare.uniform.swaps import EMPHASES, swap_points

_AIM = 0.5
"""Share of the tolerance that the programs aim at where swaps left a density outside; parts may miss it."""
_HALO = 4.0
"""Originals around a tile that swaps and programs look at, in radii of a Poisson disk sampling."""


def stages(job: Job, run: Run) -> None:
    """Weights, budgets, cells, swaps by color, programs."""
    clusters.stages(job, run)
    weights.stages(job, run)
    run("cells", tile_tasks(job, spread, "cells"))
    save_turns(job, 2 * _halo(job) * float(job.load("whole")["scale"]))
    run("swaps", tile_tasks(job, swap, "swapped", in_turns=True))
    job.once("deviations", partial(_find_deviations, name="swapped", result="deviations"))
    run("selection", tile_tasks(job, choose, "chosen"))


def summary(job: Job) -> dict[str, Any]:
    """Largest Z of eq. 14 over the clusters, as a share of their densities, and what the programs proved."""
    _find_deviations(job, "chosen", "result")
    result = job.load("result")
    return {
        "largest_residual": float(np.abs(result["deviations"]).max()),
        "residuals": np.abs(result["deviations"]),
        "disk_radius": float(job.load("budgets")["radius"]) * float(job.load("whole")["scale"]),
        "n_colors": int(job.load("turns")["colors"].max()) + 1,
    }


def _surface(job: Job, tile: int, near: Around) -> Surface:
    values = np.concatenate([job.map_array("surface", tile), take(job, "surface", near)])
    return surface_of(values)[0]


def _ordered(surface: Surface, order: NDArray[np.integer]) -> Surface:
    return Surface(surface.normals[order], surface.areas[order], surface.curvatures[order])


def _halo(job: Job) -> float:
    return _HALO * float(job.load("budgets")["radius"])


def spread(job: Job, tile: int) -> None:
    """Cells of a tile's own points, and the point that represents each."""
    n_keep = int(job.load("budgets")["budgets"][tile])
    n_own = len(job.map_array("points", tile))
    chosen = np.empty(0, dtype=np.intp)
    if n_keep:
        points, near = surroundings(job, tile, _halo(job))
        surface = _surface(job, tile, near)
        rims = _rims_of(points, surface, n_own, n_keep)
        own = Neighbors(points[:n_own])
        surface = Surface(surface.normals[:n_own], surface.areas[:n_own], surface.curvatures[:n_own])
        chosen = _cells(own, surface, rims, weights.weighted(job, tile), n_keep)
        job.save_array("rims", tile, np.column_stack([rims.rows, rims.directions, rims.areas]))
    job.save_array("sites", tile, chosen)
    job.save("cells", tile, count=len(chosen))


def _rims_of(points: Points, surface: Surface, n_own: int, n_keep: int) -> Rims:
    """Rims among the first ``n_own`` points, seen with those around them."""
    tree = Neighbors(points)
    n_all = min(max(1, round(n_keep * len(points) / n_own)), len(points))
    rims = find_rims(tree.sorted_points, _ordered(surface, tree.order), n_all)
    rows = tree.order[rims.rows]
    own = rows < n_own
    return Rims(rows[own].astype(np.intp), rims.directions[own], rims.areas[own])


def _in_tree(rims: Rims, tree: Neighbors) -> Rims:
    """Rims by their places in a tree, in its order."""
    places = tree.in_rows(np.arange(len(tree.order)))[rims.rows]
    order = np.argsort(places)
    return Rims(places[order], rims.directions[order], rims.areas[order])


def _cells(tree: Neighbors, surface: Surface, rims: Rims, shares: Vector, n_keep: int) -> Indices:
    """The row of the best point of each blue-noise cell, ascending."""
    ordered, own_rims = _ordered(surface, tree.order), _in_tree(rims, tree)
    return np.sort(
        tree.order[best_of_cells(tree, ordered, own_rims, shares[tree.order], n_keep)].astype(np.intp)
    )


class _Scene(NamedTuple):
    """A tile with what lies around it, in the order of a tree.

    ``own`` marks the points of the tile, ``sites`` are the rows of kept points.
    """

    tree: Neighbors
    surface: Surface
    own: Mask
    sites: Indices
    density: ClusterDensity


def _scene(job: Job, tile: int, kept_of: dict[int, str]) -> _Scene:
    """Originals within a halo of a tile, and kept points within two."""
    reach = _halo(job)
    points, near = surroundings(job, tile, 2 * reach)
    n_own = len(job.map_array("points", tile))
    kept = np.zeros(len(points), dtype=bool)
    kept[:n_own][np.asarray(job.map_array(kept_of[tile], tile))] = True
    for other in np.unique(near.tiles):
        some = np.flatnonzero(near.tiles == other)
        kept[n_own + some] = np.isin(near.places[some], job.map_array(kept_of[other], other))
    low, high = points[:n_own].min(axis=0), points[:n_own].max(axis=0)
    seen = kept | (distances_to_box(points, low, high) <= reach)
    rows = np.flatnonzero(seen)
    surface = _ordered(_surface(job, tile, near), rows)
    points, kept = points[rows], kept[rows]
    tree = Neighbors(points)
    labels, costs = tile_costs(job, tile)
    n_clusters = count_clusters(job)
    every_label = np.append(labels, np.full(len(rows) - n_own, n_clusters))[tree.order]
    every_cost = np.append(costs, np.ones(len(rows) - n_own))[tree.order]
    density = ClusterDensity(every_label, every_cost, np.ones(n_clusters + 1))
    return _Scene(
        tree,
        _ordered(surface, tree.order),
        tree.order < n_own,
        np.flatnonzero(kept[tree.order]),
        density,
    )


def swap(job: Job, tile: int) -> None:
    """Swaps of a tile's points, in sight of the kept points around it."""
    budgets = job.load("budgets")
    kept = np.asarray(job.map_array("sites", tile))
    if len(kept):
        before = set(tiles_before(job, tile).tolist())
        scene = _scene(
            job, tile, {t: "swapped_sites" if t in before else "sites" for t in range(job.n_tiles)}
        )
        emphasis = EMPHASES[job.settings["emphasis"]]
        swapped = swap_points(
            scene.tree,
            scene.surface.normals,
            scene.sites,
            n_rounds=int(job.settings["n_rounds"]),
            emphasis=emphasis,
            band=_band(job, tile, scene),
            limit=emphasis.hole_limit * float(budgets["radius"]),
            movable=scene.own,
        )
        kept = np.sort(scene.tree.order[swapped[scene.own[swapped]]].astype(np.intp))
    job.save_array("swapped_sites", tile, kept)
    _save_densities(job, tile, "swapped", kept)


def _band(job: Job, tile: int, scene: _Scene) -> DensityBand:
    """The band of every part of a cluster about the sum of costs that the weights foresee for it."""
    budgets = job.load("budgets")
    offsets = np.append(-budgets["counts"][tile] * (budgets["means"][tile] - 1.0), 0.0)
    tolerance = BAND * float(job.settings["density_tolerance"])
    return DensityBand(scene.density.labels, scene.density.costs, tolerance, offsets)


def _save_densities(job: Job, tile: int, name: str, kept: Indices) -> None:
    labels, costs = tile_costs(job, tile)
    n_clusters = count_clusters(job)
    job.save(
        name,
        tile,
        counts=np.bincount(labels[kept], minlength=n_clusters),
        costs=np.bincount(labels[kept], costs[kept], n_clusters),
    )


def _find_deviations(job: Job, name: str, result: str) -> None:
    """Mean cost of the kept points of every cluster of the whole cloud, less one."""
    sums = job.sums(name)
    job.save(result, deviations=quotients(sums["costs"], sums["counts"], 1.0) - 1.0)


def choose(job: Job, tile: int) -> None:
    """The program of every part of a cluster: one point per cell, the density kept."""
    kept = np.asarray(job.map_array("swapped_sites", tile))
    if len(kept):
        scene = _scene(job, tile, dict.fromkeys(range(job.n_tiles), "swapped_sites"))
        chosen = _solve(job, tile, scene, kept)
        kept = np.sort(scene.tree.order[chosen].astype(np.intp))
    job.save_array("kept", tile, np.asarray(job.map_array("rows", tile))[kept])
    _save_densities(job, tile, "chosen", kept)


def _solve(job: Job, tile: int, scene: _Scene, kept: Indices) -> Indices:
    tolerance = float(job.settings["density_tolerance"])
    deviations = job.load("deviations")["deviations"]
    inside = np.clip(deviations, -_AIM * tolerance, _AIM * tolerance)
    labels, costs = tile_costs(job, tile)
    counts = np.bincount(labels[kept], minlength=len(deviations))
    means = np.bincount(labels[kept], costs[kept], len(deviations)) / np.maximum(counts, 1)
    targets = np.append(np.where(counts > 0, np.maximum(means - deviations + inside, 1e-3), 1.0), 1.0)
    narrow = np.append(BAND - np.abs(inside) / tolerance, 1.0) if tolerance else np.ones(len(targets))
    scaled = _about(scene.density, targets, narrow)
    known = np.asarray(job.map_array("rims", tile))
    rims = _in_tree(Rims(known[:, 0].astype(np.intp), known[:, 1:4].copy(), known[:, 4].copy()), scene.tree)
    chosen, _, _ = solve_programs(
        scene.tree.sorted_points,
        scene.surface,
        rims,
        scaled,
        scene.sites,
        tolerance=tolerance,
        stop=Stop(float(job.settings["gap"]), float(job.settings["time_limit"])),
        movable=scene.own,
    )
    return chosen[scene.own[scene.sites]]


def _about(density: ClusterDensity, targets: Vector, widths: Vector) -> ClusterDensity:
    """Costs about the targets of the clusters, so that one tolerance stands for ``widths`` of it."""
    labels = density.labels
    return ClusterDensity(labels, 1.0 + (density.costs / targets[labels] - 1.0) / widths[labels], targets)
