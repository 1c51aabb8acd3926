"""`lp_uniform` and `lp_placed` for the whole cloud: cells, refinement, and the program of every cluster."""

from __future__ import annotations

from dataclasses import dataclass
from threading import Event

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface
from lpcompare.paper.density import inverse_distance_costs
from lpcompare.threads import Progress, map_in_threads
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare.uniform.cells import blue_noise_centers, sampling_weights, tilt_to_density
from lpcompare.uniform.densities import DensityBand
from lpcompare.uniform.program import SpreadCertificate, Stop, select_one_per_cell
from lpcompare.uniform.quadrics import cheapest_of_each, tangent_quadrics
from lpcompare.uniform.rims import Rims
from lpcompare.uniform.swaps import Emphasis, swap_points

_SPREAD = 0.05
BAND = 0.8


@dataclass(frozen=True, eq=False)
class ClusterDensity:
    """Eqs. 12 and 13 for every point of the cloud.

    Attributes
    ----------
    labels : ndarray of int, shape (n,)
    costs : ndarray, shape (n,)
        C_i divided by the density D_c of the point's cluster.
    densities : ndarray, shape (K,)
        D_c = mean of 1 / d_i, in 1 / unit of the points; 1 where a cluster has no extent or no point.
    """

    labels: Indices
    costs: Vector
    densities: Vector


def cluster_densities(points: Points, labels: Indices) -> ClusterDensity:
    """Inverse distances to the centroids of the clusters ``labels`` (n,) of ``points`` (n, 3)."""
    costs, densities = np.ones(len(points)), np.ones(int(labels.max()) + 1)
    for cluster in np.flatnonzero(np.bincount(labels)):
        rows = np.flatnonzero(labels == cluster)
        costs[rows], densities[cluster] = inverse_distance_costs(points[rows], points[rows].mean(axis=0))
    return ClusterDensity(labels, costs, densities)


def spread_points(
    tree: Neighbors, surface: Surface, rims: Rims, curvature: Vector, density: ClusterDensity, n_keep: int
) -> Indices:
    """One original per blue-noise cell, the one that represents it best: ``n_keep`` ascending rows."""
    weights = tilt_to_density(sampling_weights(surface.areas, curvature), density.costs, density.labels)
    return best_of_cells(tree, surface, rims, weights, n_keep)


def best_of_cells(tree: Neighbors, surface: Surface, rims: Rims, weights: Vector, n_keep: int) -> Indices:
    """The original that represents each blue-noise cell of weighted points best: ``n_keep`` ascending rows."""
    points = tree.sorted_points
    centers = blue_noise_centers(tree, weights, n_keep)
    quadrics = tangent_quadrics(points, surface, rims, centers)
    costs = quadrics.costs(points, _SPREAD)
    chosen = cheapest_of_each(costs, quadrics.owners, n_keep)
    return _filled(points, chosen[chosen >= 0], n_keep)


def _filled(points: Points, chosen: Indices, n_keep: int) -> Indices:
    """Add the originals farthest from ``chosen``: coinciding centres leave cells without a point."""
    if len(chosen) < n_keep:
        free = np.delete(np.arange(len(points)), chosen)
        gaps = Neighbors(points[chosen]).query(points[free], 1)[0][:, 0]
        chosen = np.append(chosen, free[np.argsort(-gaps, kind="stable")[: n_keep - len(chosen)]])
    return np.sort(chosen)


def refine_in_density(
    tree: Neighbors,
    surface: Surface,
    indices: Indices,
    density: ClusterDensity,
    *,
    n_rounds: int,
    tolerance: float,
    emphasis: Emphasis,
) -> Indices:
    """Swap points against their error while every cluster keeps its density."""
    band = DensityBand(density.labels, density.costs, BAND * tolerance)
    return swap_points(tree, surface.normals, indices, n_rounds=n_rounds, emphasis=emphasis, band=band)


def solve_programs(
    points: Points,
    surface: Surface,
    rims: Rims,
    density: ClusterDensity,
    sites: Indices,
    *,
    tolerance: float,
    stop: Stop,
    progress: Progress | None = None,
    movable: Mask | None = None,
) -> tuple[Indices, Indices, list[SpreadCertificate]]:
    """One point per cell of ``sites``, chosen by the program of each cluster, in parallel threads.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    surface : Surface
    rims : Rims
    density : ClusterDensity
    sites : ndarray of int, shape (m,)
        Rows whose nearest originals are the cells; each belongs to the cluster of its site.
    tolerance : float
        Largest Z of eq. 14 that costs nothing, as a share of the cluster's density.
    stop : Stop
    progress : callable, optional
        Called with (clusters done, clusters).
    movable : ndarray of bool, shape (n,), optional
        Rows of the part of a larger cloud that is chosen from; no point is chosen for sites elsewhere.

    Returns
    -------
    indices : ndarray of int, shape (m,)
        The choice of each site; a site that is not movable itself.
    cells : ndarray of int, shape (n,)
        The site of each original.
    certificates : list of SpreadCertificate
        One per cluster that owns a site, densities in 1 / unit of the points.
    """
    quadrics = tangent_quadrics(points, surface, rims, points[sites])
    costs = quadrics.costs(points, _SPREAD)
    owners = _own_sites(quadrics.owners, sites)
    allowed = _candidates(points, density.labels, sites, owners)
    if movable is not None:
        allowed &= movable & movable[sites[owners]]
    candidates = np.flatnonzero(allowed)
    clusters = density.labels[candidates]
    cancelled = Event()

    def solve(rows: Indices) -> tuple[Indices, SpreadCertificate]:
        _, cells = np.unique(owners[rows], return_inverse=True)
        mask, certificate = select_one_per_cell(
            costs[rows],
            cells,
            density.costs[rows],
            tolerance=tolerance,
            stop=stop,
            cancelled=cancelled,
        )
        return rows[mask], certificate.in_units(float(density.densities[density.labels[rows[0]]]))

    order = candidates[np.argsort(clusters, kind="stable")]
    groups = np.split(order, np.cumsum(np.bincount(clusters))[:-1])
    results = map_in_threads(solve, [rows for rows in groups if len(rows)], progress, cancelled)
    indices = sites.copy()
    for rows, _ in results:
        indices[owners[rows]] = rows
    return indices, owners, [certificate for _, certificate in results]


def _own_sites(owners: Indices, sites: Indices) -> Indices:
    """Every site owns itself, also where another site lies at the same place."""
    owners = owners.copy()
    owners[sites] = np.arange(len(sites))
    return owners


def _candidates(points: Points, labels: Indices, sites: Indices, owners: Indices) -> Mask:
    """Originals that may stand for their cell: of its cluster, and opening no hole wider than there is."""
    steps = np.linalg.norm(points - points[sites[owners]], axis=1)
    radii = np.zeros(len(sites))
    np.maximum.at(radii, owners, steps)
    close = steps + radii[owners] <= radii.max()
    close[sites] = True
    return close & (labels == labels[sites[owners]])
