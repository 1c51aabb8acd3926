"""Random choice weighted by curvature: rough places keep more points (numpy).

The weight of a point is the surface variation of its neighbourhood, the share of its variance that lies along
the normal, after Pauly, Gross and Kobbelt; a floor keeps flat places from being emptied.
"""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._hoods import planes_and_variation
from lpcompare_baselines._orders import drawn_by_weight

TRAITS = Traits(
    family="curvature",
    wraps="numpy, scipy.spatial.KDTree",
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    licence="BSD-3-Clause",
)


def curvature_sample(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 16,
    floor: float = 0.5,
) -> Simplification:
    """Keep ``target_count`` rows, drawn without replacement in proportion to their weights.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
    n_neighbors : int, optional
        Points of a neighbourhood.
    floor : float, optional
        Weight of a flat place, as a share of the mean variation.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    _, variation = planes_and_variation(points, Neighbors(points).query(points, n_neighbors)[1])
    weights = variation + (floor * variation.mean() or 1.0)
    indices = drawn_by_weight(weights, target_count, rng)
    return Simplification(points[indices], indices)
