"""The filters of lpcompare by name, in the order in which they are listed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from lpcompare.meshlab import fields, simplification
from lpcompare.meshlab.parameters import Parameter


@dataclass(frozen=True)
class Filter:
    """One filter.

    Attributes
    ----------
    name : str
        A verb of MeshLab's first: generate_ adds a layer, compute_ fills a value per vertex, get_ returns.
    run : callable
        Takes the MeshSet and the checked parameters; returns the dictionary of results.
    parameters : tuple of Parameter
    """

    name: str
    run: Callable[[Any, Mapping[str, Any]], dict[str, Any]]
    parameters: tuple[Parameter, ...]

    @property
    def documentation(self) -> str:
        """Text for help(): what the function's docstring says, then every parameter."""
        lines = [f"    {p.name} : {p.type_name} = {p.default!r}\n        {p.doc}" for p in self.parameters]
        return "\n".join([(self.run.__doc__ or "").strip(), "", "    Parameters", "    ----------", *lines])


FILTERS = {
    filter_.name: filter_
    for filter_ in (
        Filter(
            "generate_simplified_point_cloud_linear_programming",
            simplification.simplify_layer,
            simplification.PARAMETERS,
        ),
        Filter(
            "generate_simplified_point_cloud_uniform_linear_programming",
            simplification.simplify_layer_uniformly,
            simplification.UNIFORM_PARAMETERS,
        ),
        Filter("compute_scalar_by_plane_error_per_vertex", fields.fill_plane_error, fields.FILL_PARAMETERS),
        Filter("compute_absolute_curvature_per_vertex", fields.fill_curvature, fields.CURVATURE_PARAMETERS),
        Filter(
            "compute_expectation_maximization_clusters_per_vertex",
            fields.fill_clusters,
            fields.CLUSTER_PARAMETERS,
        ),
        Filter("get_plane_error", fields.measure_plane_error, fields.MEASURE_PARAMETERS),
    )
}
