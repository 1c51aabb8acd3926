"""Filters as methods of `pymeshlab.MeshSet`, with real signatures, and off again."""

from __future__ import annotations

import functools
import inspect
from threading import RLock
from typing import Any

from lpcompare.mesh_library import pymeshlab
from lpcompare.meshlab.application import apply_filter
from lpcompare.meshlab.filters import FILTERS, Filter
from lpcompare.meshlab.layers import ATTRIBUTE_NAMES
from lpcompare.meshlab.parameters import LENGTH

_NAMING = ("add_vertex_custom_scalar_attribute", "add_vertex_custom_point_attribute")
_LOCK = RLock()
_replaced: dict[tuple[Any, str], Any] = {}


def install() -> None:
    """Bind the filters of lpcompare on `pymeshlab.MeshSet`; a second call changes nothing.

    Every MeshSet has them, also one that exists already. pymeshlab can read a custom attribute by its name
    but lists no names, so that the two methods of `pymeshlab.Mesh` that add one are wrapped to note them.

    Raises
    ------
    Unavailable
        pymeshlab or one of its system libraries is missing.
    """
    known = pymeshlab()
    with _LOCK:
        if _replaced:
            return
        for filter_ in FILTERS.values():
            _replace(known.MeshSet, filter_.name, _method(filter_))
        for name in _NAMING:
            _replace(known.Mesh, name, _naming(getattr(known.Mesh, name)))


def uninstall() -> None:
    """Take back what `install` did; without it, nothing happens."""
    with _LOCK:
        for (owner, name), original in _replaced.items():
            if original is None:
                delattr(owner, name)
            else:
                setattr(owner, name, original)
        _replaced.clear()


def _replace(owner: Any, name: str, function: Any) -> None:
    _replaced[owner, name] = vars(owner).get(name)
    setattr(owner, name, function)


def _method(filter_: Filter) -> Any:
    """The filter as a method; None in place of an empty dictionary, as pymeshlab's own methods."""

    def method(self: Any, **parameters: Any) -> dict[str, Any] | None:
        return apply_filter(self, filter_.name, **parameters) or None

    method.__name__ = filter_.name
    method.__qualname__ = f"MeshSet.{filter_.name}"
    method.__doc__ = filter_.documentation
    method.__signature__ = _signature(filter_)  # pyright: ignore[reportFunctionMemberAccess]
    return method


def _signature(filter_: Filter) -> inspect.Signature:
    kinds = inspect.Parameter
    own = [
        kinds(p.name, kinds.KEYWORD_ONLY, default=p.default, annotation=LENGTH if p.length else p.type)
        for p in filter_.parameters
    ]
    return inspect.Signature([kinds("self", kinds.POSITIONAL_OR_KEYWORD), *own], return_annotation=dict)


def _naming(original: Any) -> Any:
    @functools.wraps(original)
    def method(self: Any, attribute_values: Any, attribute_name: str) -> None:
        original(self, attribute_values, attribute_name)
        ATTRIBUTE_NAMES.add(attribute_name)

    return method
