"""Random choice weighted by a high-pass graph filter: points that differ from their neighbours' mean stay.

Chen, Tian, Feng, Vetro and Kovacevic, Fast resampling of three-dimensional point clouds via graphs.

1. The points are joined to their nearest others; the edges weigh W_ij = exp(-d_ij^2 / s^2).
2. A point's feature is the length of row i of h(A) X with the Haar-like high-pass filter h(A) = I - A and the
   random-walk matrix A = D^-1 W: its offset from its neighbours' weighted mean.
3. Points are drawn with probability pi_i in proportion to that length. It changes with neither a shift, nor a
   rotation, nor the scale.

Decisions: the neighbours are the nearest 15, in both directions, where the paper takes a radius, because a
radius needs a scale; s is the root mean square edge length; the draw is without replacement, as in public
implementations (the paper's analysis draws with replacement), because a thinned cloud has no repeated points.
On a plane that is sampled irregularly the filter sees the irregularity.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.graphs import gaussian_graph, high_pass
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._orders import drawn_by_weight

TRAITS = Traits(
    wraps="numpy, scipy.sparse",
    source="Chen, Tian, Feng, Vetro and Kovacevic, Fast resampling of three-dimensional point clouds via "
    "graphs, IEEE Transactions on Signal Processing 66(3), 2018",
    licence="BSD-3-Clause",
    family="graph",
)


def chen_graph(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 15
) -> Simplification:
    """Keep ``target_count`` rows, drawn in proportion to their high-pass response.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
    n_neighbors : int, optional
        Nearest points that each point is joined to.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    response = np.linalg.norm(high_pass(gaussian_graph(points, n_neighbors), points), axis=1)
    indices = drawn_by_weight(response, target_count, rng)
    return Simplification(points[indices], indices)
