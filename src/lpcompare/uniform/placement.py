"""`lp_placed`: kept points moved to where they represent the originals around them best.

Kept points of a convex surface lie on it, so that every plane through them cuts below it. The minimum of the
tangent-plane quadric of a point lies a little outside, or on the edge where planes meet. The quadric needs no
mesh; it is held to the kept point where the planes say nothing, and no point moves farther than a share of
its spacing.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface
from lpcompare.types import Indices, Points
from lpcompare.uniform.quadrics import tangent_quadrics

_STIFFNESS = 0.1
_LARGEST_STEP = 0.25


def place_points(points: Points, surface: Surface, indices: Indices) -> Points:
    """Move each kept point to the minimum of the quadric of its originals.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The original cloud.
    surface : Surface
        Of ``points``.
    indices : ndarray of int, shape (m,)
        Rows that were kept.

    Returns
    -------
    ndarray, shape (m, 3)
        In the order of ``indices``, each moved by at most a quarter of its distance to the next kept point.
    """
    sites = points[indices]
    moved = tangent_quadrics(points, surface, sites).minima(_STIFFNESS)
    spacings = Neighbors(sites).query(sites, 2)[0][:, -1]
    steps = np.linalg.norm(moved - sites, axis=1)
    shares = np.minimum(1.0, _LARGEST_STEP * spacings / np.where(steps > 0, steps, 1.0))
    return sites + (moved - sites) * shares[:, None]
