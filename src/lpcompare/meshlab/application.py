"""Calling a filter by name on a MeshSet: parameters checked, errors in pymeshlab's class and wording."""

from __future__ import annotations

import sys
from typing import Any

from lpcompare.errors import LpcompareError
from lpcompare.mesh_library import pymeshlab
from lpcompare.meshlab.filters import FILTERS, Filter
from lpcompare.meshlab.scripts import recorded


def filter_list() -> list[str]:
    """Names of the filters of lpcompare."""
    return list(FILTERS)


def apply_filter(layers: Any, filter_name: str, /, **parameters: Any) -> dict[str, Any]:
    """Apply a filter, of lpcompare or of MeshLab, to a MeshSet.

    Parameters
    ----------
    layers : pymeshlab.MeshSet
    filter_name : str
        One of `filter_list`, or of pymeshlab.filter_list().
    **parameters
        Those of the filter; what is left out takes its default.

    Returns
    -------
    dict
        Results of the filter; empty where there are none.

    Raises
    ------
    pymeshlab.PyMeshLabException
        As pymeshlab raises it: no such filter or parameter, a value of the wrong type, no mesh, and
        whatever keeps the filter from working.
    """
    if filter_name not in FILTERS:
        return layers.apply_filter(filter_name, **parameters)
    filter_, refusal = FILTERS[filter_name], pymeshlab().PyMeshLabException
    if layers.mesh_number() == 0:
        raise refusal(f"{filter_name} requires at least one mesh loaded in the MeshSet.")
    values = _checked(filter_, layers, parameters)
    try:
        with recorded(layers, filter_, values):
            return filter_.run(layers, values)
    except LpcompareError as error:
        raise refusal(f"Failed to apply filter: {filter_name}\nDetails: {error}") from error


def print_filter_parameter_list(filter_name: str) -> None:
    """Print the parameters of a filter with their types and defaults, in pymeshlab's form."""
    if filter_name not in FILTERS:
        pymeshlab().print_filter_parameter_list(filter_name)
        return
    sys.stdout.write(f"{filter_name} filter - list of parameter names:\n")
    for parameter in FILTERS[filter_name].parameters:
        default = f"'{parameter.default}'" if isinstance(parameter.default, str) else parameter.default
        choices = f" (or int, {len(parameter.choices)} values)" if parameter.choices else ""
        sys.stdout.write(f"\t{parameter.name} : {parameter.type_name}{choices} = {default}\n")


def _checked(filter_: Filter, layers: Any, given: dict[str, Any]) -> dict[str, Any]:
    """Every parameter with its checked value."""
    known = {parameter.name: parameter for parameter in filter_.parameters}
    for name in given:
        if name not in known:
            raise pymeshlab().PyMeshLabException(
                f"Parameter {name} not found for filter {filter_.name}. Please check the documentation."
            )
    return {name: p.checked(given.get(name, p.default), layers) for name, p in known.items()}
