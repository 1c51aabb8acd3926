"""Values per vertex, to look at: curvature, clusters, and eq. 27 between two layers, which is returned too."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lpcompare.geometry.scale import bounding_box_diagonal, normalize
from lpcompare.meshlab.layers import coordinates, fill_scalar, used_rows
from lpcompare.meshlab.parameters import SELECTED, Parameter
from lpcompare.metrics.comparison import Comparison
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import estimate_curvature
from lpcompare.types import Vector

CURVATURE_PARAMETERS = (
    Parameter("neighbornum", int, 20, "Points of each quadric fit, the vertex itself among them.", low=1),
    SELECTED,
)
CLUSTER_PARAMETERS = (
    Parameter("clusternum", int, 20, "Components of the Gaussian mixture (K).", low=1),
    Parameter("randomseed", int, 0, "Seed of the start.", low=0),
    SELECTED,
)
_NEIGHBORS = Parameter("neighbornum", int, 8, "Points that carry each plane.", low=1)

MEASURE_PARAMETERS = (
    Parameter("sampledmesh", int, 0, "The original: distances are taken from its vertices.", layer=True),
    Parameter("targetmesh", int, None, "The simplified cloud; the current mesh if left out.", layer=True),
    _NEIGHBORS,
)
FILL_PARAMETERS = (
    Parameter("measuremesh", int, 0, "The original, whose vertices get the values.", layer=True),
    Parameter("refmesh", int, None, "The simplified cloud; the current mesh if left out.", layer=True),
    _NEIGHBORS,
)


def fill_curvature(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Fill the quality with the absolute curvature of a local quadric fit (eqs. 6-11 of Leal et al. 2017).

    A = abs(k1) + abs(k2), in 1 / model units; also kept as the custom attribute 'absolute_curvature'.
    Returns a dictionary: min, max, mean.
    """
    mesh = layers.current_mesh()
    rows = used_rows(mesh, values["selected"])
    cloud, _, scale = normalize(coordinates(mesh)[rows])
    absolute = estimate_curvature(cloud, values["neighbornum"]).in_units(scale).absolute
    fill_scalar(layers, mesh.id(), rows, absolute, "absolute_curvature")
    return {"min": float(absolute.min()), "max": float(absolute.max()), "mean": float(absolute.mean())}


def fill_clusters(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Fill the quality with the cluster of each vertex, by expectation maximisation of a Gaussian mixture.

    Eqs. 1-5 of Leal et al. (2017); clusters count from 0 and are also kept as the custom attribute
    'cluster'. Returns a dictionary: cluster_num, cluster_sizes.
    """
    mesh = layers.current_mesh()
    rows = used_rows(mesh, values["selected"])
    cloud = normalize(coordinates(mesh)[rows])[0]
    mixture = cluster_points(cloud, values["clusternum"], np.random.default_rng(values["randomseed"]))
    fill_scalar(layers, mesh.id(), rows, mixture.labels.astype(np.float64), "cluster")
    sizes = np.bincount(mixture.labels, minlength=mixture.n_clusters)
    return {"cluster_num": mixture.n_clusters, "cluster_sizes": sizes}


def measure_plane_error(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Distances of the vertices of one mesh to the planes of their nearest vertices in another (eq. 27).

    The error measure of Leal, Leal and Sanchez-Torres (2017). Returns a dictionary in the manner of
    get_hausdorff_distance: RMS, max, mean, min, n_samples, diag_mesh_0, diag_mesh_1, in model units, and
    mean_percent and max_percent, of the first mesh's bounding-box diagonal.
    """
    return _summary(layers, values["sampledmesh"], values["targetmesh"], values["neighbornum"])[0]


def fill_plane_error(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Fill the quality of each vertex with its distance to the plane of its nearest vertices in another mesh.

    Eq. 27 of Leal, Leal and Sanchez-Torres (2017) before the mean, in model units; also kept as the custom
    attribute 'plane_error'. Returns the dictionary of get_plane_error.
    """
    summary, distances = _summary(layers, values["measuremesh"], values["refmesh"], values["neighbornum"])
    fill_scalar(layers, values["measuremesh"], np.arange(len(distances)), distances, "plane_error")
    return summary


def _summary(layers: Any, original: int, simplified: int, n_neighbors: int) -> tuple[dict[str, Any], Vector]:
    first, second = (coordinates(layers.mesh(mesh_id)) for mesh_id in (original, simplified))
    comparison = Comparison(first, second)
    distances = comparison.plane_errors(n_neighbors)
    largest = float(distances.max())
    return {
        "RMS": float(np.sqrt((distances**2).mean())),
        "diag_mesh_0": comparison.diagonal,
        "diag_mesh_1": bounding_box_diagonal(second),
        "max": largest,
        "max_percent": comparison.percent(largest),
        "mean": float(distances.mean()),
        "mean_percent": comparison.plane_error_percent(n_neighbors),
        "min": float(distances.min()),
        "n_samples": len(distances),
    }, distances
