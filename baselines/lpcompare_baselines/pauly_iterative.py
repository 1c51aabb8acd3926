"""Iterative simplification: neighboring pairs of points are contracted, the least quadric error first.

Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002, section 3.2:
the quadric error of Garland and Heckbert (SIGGRAPH 1997) without a mesh.

1. Each point makes a pair with each of its k nearest points.
2. The quadric Q_p of a point is the sum of the squared distances to the planes E_i through p that are spanned
   by the edge e_i to a neighbor and b_i = e_i x n, with n the normal at p.
3. The cost of a pair is the least value of Q_p + Q_q. The cheapest pair is contracted to the place of that
   least value, its quadric is the sum, its neighbors are those of both; until the count is reached.

What the publication leaves open is decided here:

- k is 8; its estimate of memory assumes 6, which leaves more pieces on uneven clouds. The normal is that of
  the plane through the 12 nearest points. Planes are not weighted.
- The place: A x = -b is solved from the middle of the pair, without the eigenvalues of A below a thousandth
  of the largest, so that on a flat or straight part the point stays as near to the middle as it can. The cost
  counts every eigenvalue above rounding, whatever the place. So no contraction costs less than one before it:
  the least value of a sum is at least the sum of the least values.
- Costs below 1e-12 of the mean squared length of a pair are rounding and count as equal. Of equal costs, the
  shorter pair goes first: on a plane nothing else would order them.
- A point has at most 16 neighbors, the nearest ones of what it inherits: the union would grow without end.
- When no pair is left, because what remains lies apart, each remaining point makes pairs with its k nearest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.planes import fit_planes
from lpcompare.geometry.scale import about_center, bounding_box_center
from lpcompare.types import Indices, Mask, Points, Simplification, Traits, Vector
from lpcompare_baselines._contraction import ROUNDING, contract, link, tangent_quadrics

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="surface",
    moves_points=True,
    keeps_attributes=False,
)

_NORMAL_NEIGHBORS = 12
_MOST_NEIGHBORS = 16
_FLAT = 1e-3


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


@dataclass
class Contraction:
    """A cloud after its contractions.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Where each row of the input is now, about the center of the input's bounding box.
    alive : ndarray of bool, shape (n,)
        Rows that were not contracted into another one.
    quadrics : ndarray, shape (n, 10)
        Of the living rows, the sum of the quadrics of all that went into them.
    costs : ndarray, shape (n - target_count,)
        Cost of each contraction, in order.
    """

    points: Points
    alive: Mask
    quadrics: NDArray[np.float64]
    costs: Vector


def contract_pairs(points: Points, target_count: int, n_neighbors: int, *, subset: bool) -> Contraction:
    """Contract pairs of a cloud until ``target_count`` rows are left; the parameters are the method's.

    When no pair is left because the rest lies apart, pairs are made anew from the nearest living rows.
    """
    places, living = about_center(points), np.arange(len(points))
    nearest = nearest_others(places, max(n_neighbors, _NORMAL_NEIGHBORS))[1]
    normals = fit_planes(places, np.column_stack([living, nearest[:, :_NORMAL_NEIGHBORS]]))[1]
    nearest = nearest[:, :n_neighbors]
    quadrics = tangent_quadrics(places, normals, nearest)
    alive, costs, done = np.ones(len(points), dtype=np.bool_), np.empty(len(points) - target_count), 0
    while done < len(costs):
        pairs, lengths = _pairs(places, living, nearest)
        neighbors = np.zeros((len(points), _MOST_NEIGHBORS), dtype=np.intp)
        degrees = np.zeros(len(points), dtype=np.intp)
        link(pairs, neighbors, degrees)
        floor = ROUNDING * float(np.square(lengths).mean())
        done += contract(places, quadrics, neighbors, degrees, alive, costs[done:], subset, _FLAT, floor)
        living = np.flatnonzero(alive)
        nearest = nearest_others(places[living], n_neighbors)[1]
    return Contraction(places, alive, quadrics, costs)


def _pairs(points: Points, living: Indices, nearest: NDArray[np.intp]) -> tuple[NDArray[np.intp], Vector]:
    """Each pair of a living row and one of its nearest, shape (p, 2), the shortest first; their lengths."""
    ends = np.stack(np.broadcast_arrays(np.arange(len(living))[:, None], nearest), axis=2).reshape(-1, 2)
    pairs = living[np.unique(np.sort(ends, axis=1), axis=0)]
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    order = np.argsort(lengths, kind="stable")
    return pairs[order], lengths[order]
