"""Two steps of the method as values per vertex, to look at: curvature and clusters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lpcompare.geometry.scale import normalize
from lpcompare.meshlab.layers import coordinates, fill_scalar, used_rows
from lpcompare.meshlab.parameters import Parameter
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import estimate_curvature

_SELECTED = Parameter("selected", bool, False, "Work on the selected vertices only.")

CURVATURE_PARAMETERS = (
    Parameter("neighbornum", int, 20, "Points of each quadric fit, the vertex itself among them.", low=1),
    _SELECTED,
)
CLUSTER_PARAMETERS = (
    Parameter("clusternum", int, 20, "Components of the Gaussian mixture (K).", low=1),
    Parameter("randomseed", int, 0, "Seed of the start.", low=0),
    _SELECTED,
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
