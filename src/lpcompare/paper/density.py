"""Stage 3: the cost of a point and the density of a cluster, eqs. 12, 13 and 15 of Leal et al. (2017)."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Vector

NEAREST = 1e-3
_STEP = 2.0**-36


def inverse_distance_costs(points: Points, centroid: Vector) -> tuple[Vector, float]:
    """C_i = 1 / d_i (eq. 13), divided by the cluster's mean cost.

    A point on the centroid has no finite cost in eq. 13: distances count as at least 1/1000 of the root mean
    square distance. Costs are rounded to 2^-36 of their mean, so that points that are equally far stay
    equally far when the cloud is rotated.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        The points of one cluster.
    centroid : ndarray, shape (3,)

    Returns
    -------
    costs : ndarray, shape (n,)
        Mean one; all one where every point lies on the centroid.
    mean_cost : float
        The mean that was divided out, in 1 / unit of ``points``; 1 where there is no distance.
    """
    distances = np.linalg.norm(points - centroid, axis=1)
    typical = float(np.sqrt(np.mean(distances**2))) if len(points) else 0.0
    if typical == 0:
        return np.ones(len(points)), 1.0
    costs = 1.0 / np.maximum(distances, NEAREST * typical)
    mean_cost = float(costs.mean())
    return np.rint(costs / mean_cost / _STEP) * _STEP, mean_cost


def cluster_density(costs: Vector, mean_cost: float, definition: str) -> float:
    """Density D_c of a cluster in units of its mean cost.

    Parameters
    ----------
    costs : ndarray, shape (n,)
        Normalised costs.
    mean_cost : float
        Their normaliser, in 1 / model units.
    definition : {"mean", "printed"}
        "mean" is the text's "average of the inverse distance", as eq. 15 has it for the reduced cluster;
        "printed" is eq. 12, 1 / sum(1 / d_i), a length: its answer depends on the unit of the model.

    Returns
    -------
    float
    """
    if not len(costs):
        return 0.0
    if definition == "mean":
        return float(costs.mean())
    return 1.0 / (float(costs.sum()) * mean_cost) / mean_cost
