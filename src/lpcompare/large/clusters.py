"""What the methods of programs need of the whole cloud: curvature, clusters, densities, from sums over tiles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface, estimate_surface
from lpcompare.paper.cluster_count import AUTO, check_n_clusters, choose_n_clusters
from lpcompare.paper.clustering import Mixture, assign, cluster_points
from lpcompare.paper.curvature import Curvature
from lpcompare.paper.density import NEAREST
from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import Around, Run, around, normalized, spilling, take, tile_tasks
from lpcompare.types import Indices, Points, Vector

_PROBED = 4096
_FARTHEST = 0.999
_MARGIN = 1.5
_NO_POINTS: Points = np.empty((0, 3))


def stages(job: Job, run: Run) -> None:
    """Surface and cluster of every point; centroids, densities and curvature of every cluster."""
    spilling(job, run)
    job.once("mixture", _fit)
    run("curvature", tile_tasks(job, measure, "measured"))
    job.once("clusters", _find_centroids)
    run("densities", tile_tasks(job, sum_inverse_distances, "inverse"))
    job.once("densities", _find_densities)


def _find_densities(job: Job) -> None:
    """Mean inverse distance of every cluster (eq. 12)."""
    sums = job.sums("inverse")["sums"]
    counts = job.load("clusters")["counts"]
    means = np.divide(sums, counts, out=np.ones(len(sums)), where=(counts > 0) & (sums > 0))
    job.save("densities", means=means)


def _fit(job: Job) -> None:
    """The mixture (eqs. 1-5) of the sample."""
    rng = np.random.default_rng(job.seed)
    sample = normalized(job, job.load("sample")["points"])
    wanted = check_n_clusters(job.settings["n_clusters"])
    n_clusters = choose_n_clusters(sample, rng).n_clusters if wanted == AUTO else int(wanted)
    mixture = cluster_points(sample, n_clusters, rng)
    job.save("mixture", weights=mixture.weights, means=mixture.means, covariances=mixture.covariances)


def surroundings(job: Job, tile: int, reach: float) -> tuple[Points, Around]:
    """The normalised points of a tile and then those around it; ``reach`` is normalised too."""
    near = around(job, tile, reach * float(job.load("whole")["scale"]))
    points = np.concatenate([job.map_array("points", tile), take(job, "points", near)])
    return normalized(job, points), near


def measure(job: Job, tile: int) -> None:
    """Surface and cluster of every point of a tile, and the sums of its clusters."""
    own, n_neighbors = normalized(job, job.map_array("points", tile)), int(job.settings["n_neighbors"])
    n_own = len(own)
    labels = assign(own, _mixture(job)) if n_own else np.empty(0, dtype=np.intp)
    values = np.empty((n_own, 5))
    if n_own:
        points, _ = surroundings(job, tile, neighbor_reach(own, max(n_neighbors, 10)))
        tree = Neighbors(points)
        surface = estimate_surface(tree, n_neighbors)
        curvature = Curvature(*surface.curvatures.T).absolute
        values = tree.in_rows(np.column_stack([surface.normals, surface.areas, curvature]))[:n_own]
    k = len(job.load("mixture")["weights"])
    job.save_array("labels", tile, labels.astype(np.int16))
    job.save_array("surface", tile, values)
    job.save(
        "measured",
        tile,
        counts=np.bincount(labels, minlength=k),
        totals=np.column_stack([np.bincount(labels, x, k) for x in own.T]),
        squares=np.bincount(labels, (own**2).sum(axis=1), k),
        curvature=np.bincount(labels, values[:, 4], k),
        smallest_area=values[values[:, 3] > 0, 3].min(initial=np.inf),
    )


def neighbor_reach(points: Points, n_neighbors: int) -> float:
    """How far around a tile the nearest neighbours of nearly all of its points are."""
    probe = points[:: max(1, len(points) // _PROBED)]
    distances = Neighbors(points).query(probe, n_neighbors)[0][:, -1]
    return _MARGIN * float(np.quantile(distances, _FARTHEST))


def _mixture(job: Job) -> Mixture:
    parts = job.load("mixture")
    none = np.empty(0)
    return Mixture(none.astype(np.intp), parts["weights"], parts["means"], parts["covariances"], none, True)


def _find_centroids(job: Job) -> None:
    """Centroid, root mean square distance and mean curvature of every cluster."""
    sums = job.sums("measured")
    counts = np.maximum(sums["counts"], 1)
    centroids = sums["totals"] / counts[:, None]
    squares = sums["squares"] / counts - (centroids**2).sum(axis=1)
    smallest = job.gather("measured")["smallest_area"].min()
    n_points = int(sums["counts"].sum())
    job.save(
        "clusters",
        counts=sums["counts"],
        centroids=centroids,
        radii=np.sqrt(np.maximum(squares, 0.0)),
        curvature=sums["curvature"] / counts,
        mean_curvature=sums["curvature"].sum() / n_points,
        smallest_area=smallest,
    )


def count_clusters(job: Job) -> int:
    """Clusters of the whole cloud."""
    return len(job.load("clusters")["counts"])


class TileClusters(NamedTuple):
    """Cluster of every point of a tile, and its cost C_i (eq. 13) divided by the density of its cluster."""

    labels: Indices
    costs: Vector


def tile_costs(job: Job, tile: int) -> TileClusters:
    """Eqs. 12 and 13 for the points of a tile, with the centroids and densities of the whole cloud."""
    labels = np.asarray(job.map_array("labels", tile), dtype=np.intp)
    return TileClusters(
        labels, _inverse_distances(job, tile, labels) / job.load("densities")["means"][labels]
    )


def sum_inverse_distances(job: Job, tile: int) -> None:
    """Sums of 1 / d_i over the clusters of a tile."""
    labels = np.asarray(job.map_array("labels", tile), dtype=np.intp)
    sums = np.bincount(labels, _inverse_distances(job, tile, labels), count_clusters(job))
    job.save("inverse", tile, sums=sums)


def _inverse_distances(job: Job, tile: int, labels: Indices) -> Vector:
    clusters = job.load("clusters")
    points = normalized(job, job.map_array("points", tile))
    distances = np.linalg.norm(points - clusters["centroids"][labels], axis=1)
    least = NEAREST * np.where(clusters["radii"] > 0, clusters["radii"], np.inf)[labels]
    return np.where(np.isfinite(least), 1.0 / np.maximum(distances, least), 1.0)


def surface_of(values: NDArray[np.float64]) -> tuple[Surface, Vector]:
    """Normals and areas as `estimate_surface` gives them, and absolute curvature, of rows of "surface"."""
    values = np.asarray(values)
    surface = Surface(np.ascontiguousarray(values[:, :3]), values[:, 3].copy(), np.empty((len(values), 0)))
    return surface, values[:, 4].copy()
