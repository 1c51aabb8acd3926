"""What the neighbours of a point say about its surface: curvature, tangent plane and area, from one pass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.neighbors import Neighbors, Rows
from lpcompare.threads import Progress
from lpcompare.types import Points, Vector

_PLANE_NEIGHBORS = 10
_AREA_NEIGHBOR = 8


@dataclass(frozen=True, eq=False)
class Surface:
    """What each point of a cloud says about its surface.

    Attributes
    ----------
    normals : ndarray, shape (n, 3)
        Of the plane through the 10 nearest points; the sign is arbitrary.
    areas : ndarray, shape (n,)
        Squared distance to the eighth neighbour.
    curvatures : ndarray, shape (n, 2)
        Mean and Gaussian curvature of the quadric through the nearest points.
    """

    normals: Points
    areas: Vector
    curvatures: NDArray[np.float64]


Visit = Callable[[slice, Rows, Points], None]
"""Work with a block of places, the neighbours (b, k) of each, nearest first, and its normals (b, 3)."""


def estimate_surface(
    neighbors: Neighbors,
    n_neighbors: int = 20,
    progress: Progress | None = None,
    visit: Visit | None = None,
) -> Surface:
    """Measure the surface at every point of a tree.

    Parameters
    ----------
    neighbors : Neighbors
    n_neighbors : int
        Points per quadric, the point itself among them; cut to the size of the cloud.
    progress : callable, optional
        Called with (blocks done, blocks).
    visit : callable, optional
        Called from several threads, once for each block, when its normals are known.

    Returns
    -------
    Surface
        In the order of ``neighbors.sorted_points``.
    """
    from lpcompare.geometry.kernels import plane_block, quadric_block

    points = neighbors.sorted_points
    n_points = len(points)
    n_area = min(_AREA_NEIGHBOR, n_points - 1)
    surface = Surface(np.empty((n_points, 3)), np.empty(n_points), np.empty((n_points, 2)))

    def measure(block: slice, squares: NDArray[np.float64], places: Rows) -> None:
        centroids = np.empty((len(places), 3))
        near = np.ascontiguousarray(places[:, :n_neighbors])
        quadric_block(points, points[block], near, surface.curvatures[block])
        near = np.ascontiguousarray(places[:, :_PLANE_NEIGHBORS])
        plane_block(points, near, centroids, surface.normals[block])
        surface.areas[block] = squares[:, n_area]
        if visit:
            visit(block, places, surface.normals[block])

    neighbors.each(points, max(n_neighbors, _PLANE_NEIGHBORS), measure, progress)
    return surface
