"""Rims: originals where the surface ends, and the direction in which it does.

On the rim of an open scan all neighbours lie on one side. A thinned surface that ends before the rim represents
nothing beyond its own end: so a kept point near the rim shall lie on it. The quadric of a cell takes this up as
the plane through each rim point across the surface, as Garland and Heckbert (SIGGRAPH 1997) hold the boundary
edges of a mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors, Rows
from lpcompare.geometry.surface import Surface, estimate_surface
from lpcompare.threads import Progress
from lpcompare.types import Indices, Points, Vector

_PER_CELL = 10
_FEWEST, _MOST = 12, 20
_ONE_SIDED = 0.3


@dataclass(frozen=True, eq=False)
class Rims:
    """Originals on rims.

    Attributes
    ----------
    rows : ndarray of int, shape (r,)
    directions : ndarray, shape (r, 3)
        Unit vectors in the tangent plane, away from the surface.
    areas : ndarray, shape (r,)
        What each stands for.
    """

    rows: Indices
    directions: Points
    areas: Vector


def surface_and_rims(
    tree: Neighbors, n_keep: int, n_neighbors: int, progress: Progress | None = None
) -> tuple[Surface, Rims]:
    """`estimate_surface` and `find_rims`, from one search for neighbours where one is enough."""
    points, n_looked_at = tree.sorted_points, _n_looked_at(len(tree.sorted_points), n_keep)
    if _stride(len(points), n_keep) > 1 or n_looked_at > n_neighbors:
        surface = estimate_surface(tree, n_neighbors, progress)
        return surface, find_rims(points, surface, n_keep)
    directions = np.zeros((len(points), 3))

    def visit(block: slice, places: Rows, normals: Points) -> None:
        near = np.ascontiguousarray(places[:, :n_looked_at])
        outward_block(points[block], normals, points, near, directions[block])

    surface = estimate_surface(tree, n_neighbors, progress, visit)
    return surface, _rims(np.arange(len(points)), directions, surface.areas)


def find_rims(points: Points, surface: Surface, n_keep: int) -> Rims:
    """Find the rims that matter when ``n_keep`` points stay.

    A point is on a rim if the mean of its neighbours is away from it, along the surface, by more than .3 of the
    neighbourhood's radius; inside a surface it is about .1, on a straight rim .42. The neighbourhoods have the
    size of two cells, so that gaps much narrower than the spacing of the kept points are no rims: of many
    points per cell, ten are looked at.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        In an order that keeps near points together.
    surface : Surface
        Of ``points``.
    n_keep : int

    Returns
    -------
    Rims
    """
    stride = _stride(len(points), n_keep)
    sample = np.arange(0, len(points), stride)
    tree = Neighbors(np.ascontiguousarray(points[sample]))
    directions, normals = np.zeros((len(sample), 3)), surface.normals[sample]

    def measure(block: slice, _: NDArray[np.float64], places: Rows) -> None:
        outward_block(tree.points[block], normals[block], tree.sorted_points, places, directions[block])

    tree.each(tree.points, _n_looked_at(len(sample), n_keep), measure)
    return _rims(sample, directions, stride * surface.areas[sample])


def _stride(n_points: int, n_keep: int) -> int:
    """One of how many points is looked at."""
    return max(1, n_points // (_PER_CELL * n_keep))


def _n_looked_at(n_points: int, n_keep: int) -> int:
    """Neighbours that fill two cells."""
    return int(np.clip(2 * n_points // n_keep, _FEWEST, _MOST))


def _rims(rows: Indices, directions: Points, areas: Vector) -> Rims:
    found = directions.any(axis=1)
    return Rims(rows[found], directions[found], areas[found])


@njit(cache=True, nogil=True)
def outward_block(points, normals, everyone, nearest, directions):
    """Fill ``directions`` (q, 3) at rims; ``nearest`` (q, k) are rows of ``everyone``."""
    size = nearest.shape[1]
    for q in range(len(points)):
        nx, ny, nz = normals[q]
        mx, my, mz, reach = 0.0, 0.0, 0.0, 0.0
        for row in nearest[q]:
            x, y, z = everyone[row] - points[q]
            mx, my, mz, reach = mx + x, my + y, mz + z, max(reach, x * x + y * y + z * z)
        height = mx * nx + my * ny + mz * nz
        mx, my, mz = mx - height * nx, my - height * ny, mz - height * nz
        length = np.sqrt(mx * mx + my * my + mz * mz)
        if length > _ONE_SIDED * size * np.sqrt(reach) and length > 0:
            directions[q, 0], directions[q, 1], directions[q, 2] = -mx / length, -my / length, -mz / length
