"""The paper's filter, and its uniform sibling, as MeshLab filters that add a layer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lpcompare.errors import InputError
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.mesh_library import pymeshlab
from lpcompare.meshlab.layers import add_subset, coordinates, used_rows
from lpcompare.meshlab.parameters import SELECTED, Parameter
from lpcompare.paper.simplifier import LPThinning
from lpcompare.simplify import simplify
from lpcompare.types import Points
from lpcompare.uniform.simplifier import UniformThinning

_FORMULATIONS = {"Density preserving": "lp_density", "As printed": "lp_printed"}
_RETENTIONS = {"Exact count": "exact-count", "Keep features": "keep-features"}

_DEFAULTS = vars(LPThinning())
_UNIFORM_DEFAULTS = vars(UniformThinning())

_HOW_MANY = (
    Parameter("samplenum", int, 1000, "Number of points to keep; at most those there are.", low=1),
    Parameter("targetperc", float, 0.0, "If not 0, the share of the points to keep instead.", 0.0, 1.0),
    Parameter(
        "maxerror",
        float,
        None,
        "If not 0, the largest eq. 27 error instead: as few points are kept as it allows.",
        length=True,
    ),
    Parameter("clusternum", int, _DEFAULTS["n_clusters"], "Components of the Gaussian mixture (K).", low=1),
    Parameter("neighbornum", int, _DEFAULTS["n_neighbors"], "Points of each curvature fit.", low=1),
)
_SEED = Parameter("randomseed", int, _DEFAULTS["random_state"], "Seed of every random draw.", low=0)

PARAMETERS = (
    *_HOW_MANY,
    Parameter(
        "formulation",
        str,
        "Density preserving",
        "Which reading of eqs. 12-26 the program of each cluster solves.",
        choices=tuple(_FORMULATIONS),
    ),
    Parameter(
        "retention",
        str,
        "Exact count",
        "Whether the count is that of all kept points, or all feature points stay and the rest is thinned.",
        choices=tuple(_RETENTIONS),
    ),
    Parameter(
        "featureshare",
        float,
        _DEFAULTS["feature_share"],
        "Largest share of a cluster's points that features take.",
        0.0,
        1.0,
    ),
    _SEED,
    SELECTED,
)
UNIFORM_PARAMETERS = (
    *_HOW_MANY,
    Parameter("exchangenum", int, _UNIFORM_DEFAULTS["n_rounds"], "Rounds of exchange against eq. 27.", low=0),
    Parameter(
        "densitytolerance",
        float,
        _UNIFORM_DEFAULTS["density_tolerance"],
        "Change of a cluster's density that costs nothing, as a share.",
        0.0,
    ),
    _SEED,
    SELECTED,
)


def simplify_layer(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Simplify the current point cloud by boolean linear programming (Leal, Leal, Sanchez-Torres 2017).

    Adds the kept vertices as a new, current layer 'LP simplified cloud' with their normals, colours,
    quality, texture coordinates, custom attributes and matrix; the source layer is not changed. Returns
    a dictionary: sample_num, sample_indices (rows of the source), cluster_num, certified_cluster_num.
    """
    return _generate(
        layers,
        values,
        "LP simplified cloud",
        {
            "method": _FORMULATIONS[values["formulation"]],
            "retention": _RETENTIONS[values["retention"]],
            "feature_share": values["featureshare"],
        },
    )


def simplify_layer_uniformly(layers: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Simplify the current point cloud without holes, one point per cell, by boolean linear programming.

    The second objective that Leal et al. (2017) leave to future work (lp_uniform). Adds the kept vertices
    as a new, current layer 'Uniform LP simplified cloud' with everything that they carry; the source layer
    is not changed. Returns a dictionary: sample_num, sample_indices, cluster_num, certified_cluster_num.
    """
    return _generate(
        layers,
        values,
        "Uniform LP simplified cloud",
        {
            "method": "lp_uniform",
            "n_rounds": values["exchangenum"],
            "density_tolerance": values["densitytolerance"],
        },
    )


def _generate(
    layers: Any, values: Mapping[str, Any], label: str, settings: Mapping[str, Any]
) -> dict[str, Any]:
    """Reduce the vertices that are asked for, in world coordinates, and add those that stay."""
    source = layers.current_mesh()
    rows = used_rows(source, values["selected"])
    points = coordinates(source)[rows]
    result = simplify(
        points,
        **_target(points, values),
        n_clusters=values["clusternum"],
        n_neighbors=values["neighbornum"],
        random_state=values["randomseed"],
        **settings,
    )
    kept = rows[result.indices]
    add_subset(layers, source, kept, label)
    return {
        "sample_num": len(kept),
        "sample_indices": kept,
        "cluster_num": result.info["n_clusters"],
        "certified_cluster_num": result.info["n_certified"],
    }


def _target(points: Points, values: Mapping[str, Any]) -> dict[str, Any]:
    """How much `lpcompare.simplify` is to keep: by error if one is given, else by share, else by number."""
    n_points, length = len(points), values["maxerror"]
    if length is not None:
        diagonal = bounding_box_diagonal(points)
        if isinstance(length, pymeshlab().PercentageValue):
            return {"max_error": length.value()}
        return {"max_error": 100 * length.value() / diagonal if diagonal > 0 else 0.0}
    if values["targetperc"] > 0:
        return {"target_count": max(1, int(round(values["targetperc"] * n_points, 9)))}
    if values["samplenum"] > n_points:
        raise InputError(
            f"Parameter samplenum: {values['samplenum']} points are asked of {n_points}; ask for fewer."
        )
    return {"target_count": values["samplenum"]}
