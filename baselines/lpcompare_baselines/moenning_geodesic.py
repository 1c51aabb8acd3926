"""Intrinsic farthest point sampling: each point is farthest along the surface from those before it.

C. Moenning and N. A. Dodgson, A new point cloud simplification algorithm, 3rd IASTED Conference on Visualization,
Imaging and Image Processing, 2003, 1027-1033 (the 2017 paper's [2]); Fast marching farthest point sampling for
point clouds and implicit surfaces, UCAM-CL-TR-565, 2003; Intrinsic point cloud simplification, GraphiCon 2004. Only
abstracts could be read, so this is a reading. Known of it: fast marching through a thin band of grid cells around
the points gives distances along the surface; the next sample is the farthest vertex of the bounded Voronoi diagram;
a front runs only as far as it comes nearer than the samples before it; the order is progressive, and the largest
distance left is a guarantee of density.

Decisions:

- Distances are shortest paths over a graph of the nearest neighbors, not over a grid. A grid joins sheets that
  are closer than its cells. Edges of the graph that leave the surface are cut; see ``_geodesic.surface_graph``.
  At a gap of one spacing of the input, some edges between two sheets remain.
  Such paths are a few per cent longer than the surface's, in all directions alike.
- The next sample is the farthest input point: on a graph that is where fronts meet.
- Each connected part of the graph begins with one sample, the largest part first: the point farthest from its
  center. Parts of up to 32 points are tied to their nearest neighbor before.
- There is no random number in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._geodesic import geodesic_farthest_points, surface_graph
from lpcompare_baselines._orders import first_of

TRAITS = Traits(
    wraps="lpcompare (scipy, numba)",
    source="Moenning and Dodgson, A new point cloud simplification algorithm, "
    "3rd IASTED Conference on Visualization, Imaging and Image Processing, 2003 (abstracts)",
    family="spacing",
    progressive=True,
    reading=True,
)


def moenning_geodesic(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 10,
    feature_weight: float = 0.0,
) -> Simplification:
    """Keep the first ``target_count`` points of the intrinsic farthest-point order.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used.
    n_neighbors : int, optional
        Neighbors of a point in the graph.
    feature_weight : float, optional
        How much more points rough places get; 0 is uniform. See ``_geodesic.surface_graph``.

    Returns
    -------
    Simplification
        A subset of the input. ``info["order"]``, shape (m,), is the rank of each kept point, from 0.
        ``info["covering_distance"]`` is the largest distance along the surface from a point of the input to its
        nearest kept one, in model units where ``feature_weight`` is 0.
    """
    surface = surface_graph(points, n_neighbors, feature_weight)
    order, distances = geodesic_farthest_points(surface, target_count)
    kept = first_of(points, order, target_count)
    info = {"covering_distance": float(distances.max()), "n_parts": len(surface.firsts)}
    return replace(kept, info={**kept.info, **info})
