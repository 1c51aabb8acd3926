"""Iterative simplification: neighbouring pairs of points are contracted, the least quadric error first.

Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002, section 3.2:
the quadric error of Garland and Heckbert (SIGGRAPH 1997) without a mesh.

1. Each point makes a pair with each of its k nearest points.
2. The quadric Q_p of a point is the sum of the squared distances to the planes E_i through p that are spanned
   by the edge e_i to a neighbour and b_i = e_i x n, with n the normal at p.
3. The cost of a pair is the least value of Q_p + Q_q. The cheapest pair is contracted to the place of that
   least value, its quadric is the sum, its neighbours are those of both; until the count is reached.

What the publication leaves open is decided here:

- k is 8; its estimate of memory assumes 6, which leaves more pieces on uneven clouds. The normal is that of
  the plane through the 12 nearest points. Planes are not weighted.
- The place: A x = -b is solved from the middle of the pair, without the eigenvalues of A below a thousandth
  of the largest, so that on a flat or straight part the point stays as near to the middle as it can. The cost
  counts every eigenvalue above rounding, whatever the place. So no contraction costs less than one before it:
  the least value of a sum is at least the sum of the least values.
- Costs below 1e-12 of the mean squared length of a pair are rounding and count as equal. Of equal costs, the
  shorter pair goes first: on a plane nothing else would order them.
- A point has at most 16 neighbours, the nearest ones of what it inherits: the union would grow without end.
- When no pair is left, because what remains lies apart, each remaining point makes pairs with its k nearest.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._contraction import contract_pairs

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="surface",
    moves_points=True,
    keeps_attributes=False,
)


def pauly_iterative(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 8
) -> Simplification:
    """Contract pairs of points to the place of their least quadric error.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    n_neighbors : int, optional
        k, the pairs that each point makes at first.

    Returns
    -------
    Simplification
        New points.
    """
    result = contract_pairs(points, target_count, n_neighbors, subset=False)
    return Simplification(result.points[result.alive] + bounding_box_center(points))
