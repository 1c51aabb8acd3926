"""Tangent-plane quadrics: how badly a point at some place represents the originals around it.

Each original belongs to its two nearest sites and adds the squared distance to its tangent plane (Garland and
Heckbert, SIGGRAPH 1997, from points instead of triangles) and a small share of its squared distance, which
decides where the surface is flat. A rim adds the squared distance to a plane across the surface, so that a
cell at the rim is represented on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface
from lpcompare.threads import for_blocks
from lpcompare.types import Indices, Points, Vector
from lpcompare.uniform.rims import Rims

_SHARED = 2


@dataclass(frozen=True, eq=False)
class Quadrics:
    """One quadric per site, in coordinates relative to the site.

    Attributes
    ----------
    sites : ndarray, shape (m, 3)
    owners : ndarray of int, shape (n,)
        Nearest site of each original.
    matrices, vectors, constants : ndarray, shapes (m, 3, 3), (m, 3), (m,)
        Area-weighted squared distance to the tangent planes: x' A x - 2 b' x + c.
    masses : ndarray, shape (m,)
        Area that each site stands for.
    """

    sites: Points
    owners: Indices
    matrices: NDArray[np.float64]
    vectors: Points
    constants: Vector
    masses: Vector

    def costs(self, points: Points, spread: float) -> Vector:
        """Cost of putting each original in the place of its site.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
            The originals.
        spread : float
            Weight of the squared distance to the site beside the squared distances to the tangent planes.

        Returns
        -------
        ndarray, shape (n,)
            Not negative.
        """
        costs = np.empty(len(points))
        arrays = self.sites, self.matrices, self.vectors, self.constants, spread * self.masses
        for_blocks(len(points), lambda b: _costs(points[b], self.owners[b], *arrays, costs[b]))
        return costs

    def minima(self, stiffness: float) -> Points:
        """Where each quadric, held to its site by ``stiffness`` times its trace, is least: shape (m, 3)."""
        traces = np.trace(self.matrices, axis1=1, axis2=2)
        held = self.matrices + (np.where(traces > 0, stiffness * traces, 1.0))[:, None, None] * np.eye(3)
        return self.sites + np.linalg.solve(held, self.vectors[:, :, None])[:, :, 0]


def tangent_quadrics(points: Points, surface: Surface, rims: Rims, sites: Points) -> Quadrics:
    """Gather the quadric of every site from the originals for which it is among the nearest sites.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    surface : Surface
        Of ``points``.
    rims : Rims
        Of ``points``.
    sites : ndarray, shape (m, 3)

    Returns
    -------
    Quadrics
    """
    n_sites = len(sites)
    nearest = Neighbors(sites).query(points, _SHARED)[1]
    matrices, vectors = np.zeros((n_sites, 3, 3)), np.zeros((n_sites, 3))
    constants, masses = np.zeros(n_sites), np.zeros(n_sites)
    sums = matrices, vectors, constants
    _gather(points, surface.normals, surface.areas, sites, nearest, *sums)
    rows = rims.rows
    _gather(points[rows], rims.directions, rims.areas, sites, nearest[rows, :1], *sums)
    for owners in nearest.T:
        masses += np.bincount(owners, surface.areas, n_sites)
    return Quadrics(sites, nearest[:, 0].copy(), matrices, vectors, constants, masses)


@njit(cache=True, nogil=True)
def _gather(points, normals, areas, sites, nearest, matrices, vectors, constants):
    """Add the squared distance to the plane through every point to the quadrics of its nearest sites."""
    for i in range(len(points)):
        area = areas[i]
        for site in nearest[i]:
            height = 0.0
            for a in range(3):
                height += (points[i, a] - sites[site, a]) * normals[i, a]
            constants[site] += area * height * height
            for a in range(3):
                vectors[site, a] += area * height * normals[i, a]
                for b in range(3):
                    matrices[site, a, b] += area * normals[i, a] * normals[i, b]


@njit(cache=True, nogil=True)
def _costs(points, owners, sites, matrices, vectors, constants, spreads, costs):
    """`Quadrics.costs` of one block."""
    for i in range(len(points)):
        site = owners[i]
        total, distance = constants[site], 0.0
        for a in range(3):
            offset = points[i, a] - sites[site, a]
            distance += offset * offset
            total -= 2 * offset * vectors[site, a]
            for b in range(3):
                total += offset * matrices[site, a, b] * (points[i, b] - sites[site, b])
        costs[i] = max(total, 0.0) + spreads[site] * distance


@njit(cache=True, nogil=True)
def cheapest_of_each(costs, cells, n_cells):
    """The row of least cost in each cell, the first among equals; -1 for a cell without rows."""
    chosen = np.full(n_cells, -1)
    for row in range(len(costs)):
        best = chosen[cells[row]]
        if best < 0 or costs[row] < costs[best]:
            chosen[cells[row]] = row
    return chosen
