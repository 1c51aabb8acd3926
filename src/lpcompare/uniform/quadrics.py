"""Tangent-plane quadrics: how badly a point at some place represents the originals around it.

Each original belongs to its two nearest sites and adds the squared distance to its tangent plane (Garland and
Heckbert, SIGGRAPH 1997, from points instead of triangles) and a small share of its squared distance, which
decides where the surface is flat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes
from lpcompare.types import Indices, Points, Vector

_NEIGHBORS = 10
_SHARED = 2
_BLOCK = 65536


@dataclass(frozen=True, eq=False)
class Surface:
    """What each point of a cloud says about its surface.

    Attributes
    ----------
    normals : ndarray, shape (n, 3)
        Of the plane through the nearest points; the sign is arbitrary.
    areas : ndarray, shape (n,)
        Squared distance to the eighth neighbour.
    """

    normals: Points
    areas: Vector


def estimate_surface(points: Points) -> Surface:
    """Tangent plane and area of every point of ``points`` (n, 3), from its nearest neighbours."""
    distances, indices = Neighbors(points).query(points, _NEIGHBORS)
    normals = np.empty_like(points)
    for start in range(0, len(points), _BLOCK):
        rows = slice(start, start + _BLOCK)
        normals[rows] = fit_planes(points[indices[rows]])[1]
    return Surface(normals, distances[:, min(8, distances.shape[1] - 1)] ** 2)


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
        offsets, cells = points - self.sites[self.owners], self.owners
        planes = np.einsum("ni,nij,nj->n", offsets, self.matrices[cells], offsets, optimize=True)
        planes += self.constants[cells] - 2 * np.einsum("ni,ni->n", offsets, self.vectors[cells])
        distances = np.einsum("ni,ni->n", offsets, offsets)
        return np.maximum(planes, 0.0) + spread * self.masses[cells] * distances

    def minima(self, stiffness: float) -> Points:
        """Where each quadric, held to its site by ``stiffness`` times its trace, is least: shape (m, 3)."""
        traces = np.trace(self.matrices, axis1=1, axis2=2)
        held = self.matrices + (np.where(traces > 0, stiffness * traces, 1.0))[:, None, None] * np.eye(3)
        return self.sites + np.linalg.solve(held, self.vectors[:, :, None])[:, :, 0]


def tangent_quadrics(points: Points, surface: Surface, sites: Points, n_shared: int = _SHARED) -> Quadrics:
    """Gather the quadric of every site from the originals for which it is among the nearest sites.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    surface : Surface
        Of ``points``.
    sites : ndarray, shape (m, 3)
    n_shared : int
        Sites that each original counts for.

    Returns
    -------
    Quadrics
    """
    n_sites = len(sites)
    nearest = Neighbors(sites).query(points, n_shared)[1]
    matrices, vectors = np.zeros((n_sites, 3, 3)), np.zeros((n_sites, 3))
    constants, masses = np.zeros(n_sites), np.zeros(n_sites)
    normals, areas = surface.normals, surface.areas
    for owners in nearest.T:
        heights = np.einsum("ni,ni->n", points - sites[owners], normals)
        constants += np.bincount(owners, areas * heights**2, n_sites)
        masses += np.bincount(owners, areas, n_sites)
        for i in range(3):
            vectors[:, i] += np.bincount(owners, areas * heights * normals[:, i], n_sites)
            for j in range(i + 1):
                matrices[:, i, j] += np.bincount(owners, areas * normals[:, i] * normals[:, j], n_sites)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        matrices[:, i, j] = matrices[:, j, i]
    return Quadrics(sites, nearest[:, 0].copy(), matrices, vectors, constants, masses)
