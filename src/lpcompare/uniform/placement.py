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
from lpcompare.uniform.rims import Rims

_STIFFNESS = 0.1
_LARGEST_STEP = 0.25
_HALVINGS = 3


def place_points(tree: Neighbors, surface: Surface, rims: Rims, indices: Indices) -> Points:
    """Move each kept point to the minimum of the quadric of its originals.

    Parameters
    ----------
    tree : Neighbors
        Of the original cloud; rows are those of ``tree.sorted_points``.
    surface : Surface
    rims : Rims
        Both of the originals.
    indices : ndarray of int, shape (m,)
        Rows that were kept.

    Returns
    -------
    ndarray, shape (m, 3)
        In the order of ``indices``. A point moves by at most a quarter of its distance to the next kept point.
        It ends no farther from the nearest original than the eighth neighbour of its own, and none of its
        originals ends farther from it than the farthest original was before; where a step breaks this, half
        of it is tried, then a quarter, then none.
    """
    points, sites = tree.sorted_points, tree.sorted_points[indices]
    quadrics = tangent_quadrics(points, surface, rims, sites)
    nearest, nearby = Neighbors(sites), np.sqrt(surface.areas[indices])
    spacings = nearest.query(sites, 2)[0][:, -1]
    steps = quadrics.minima(_STIFFNESS) - sites
    lengths = np.linalg.norm(steps, axis=1)
    steps *= np.minimum(1.0, _LARGEST_STEP * spacings / np.where(lengths > 0, lengths, 1.0))[:, None]
    limit = np.linalg.norm(points - sites[quadrics.owners], axis=1).max()
    lost = np.zeros(len(sites), dtype=bool)
    for _ in range(_HALVINGS):
        moved = sites + steps
        reach = np.zeros(len(sites))
        np.maximum.at(reach, quadrics.owners, np.linalg.norm(points - moved[quadrics.owners], axis=1))
        lost = (tree.query(moved, 1)[0][:, 0] > nearby) | (reach > limit)
        steps[lost] *= 0.5
    return sites + np.where(lost[:, None], 0.0, steps)
