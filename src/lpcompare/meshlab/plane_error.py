"""Eq. 27 between two layers: as a dictionary, and as a value per vertex."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.meshlab.layers import coordinates, fill_scalar
from lpcompare.meshlab.parameters import Parameter
from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Vector

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


def measure(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Distances of the vertices of one mesh to the planes of their nearest vertices in another (eq. 27).

    The error measure of Leal, Leal and Sanchez-Torres (2017). Returns a dictionary in the manner of
    get_hausdorff_distance: RMS, max, mean, min, n_samples, diag_mesh_0, diag_mesh_1, in model units, and
    mean_percent and max_percent, of the first mesh's bounding-box diagonal.
    """
    return _summary(layers, values["sampledmesh"], values["targetmesh"], values["neighbornum"])[0]


def fill(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
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
