"""Whether a value fits a type annotation: for settings, study files and run files."""

from __future__ import annotations

from collections.abc import Mapping
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin


def fits(value: object, hint: Any) -> bool:
    """Whether ``value``, as JSON or TOML gave it, may stand where ``hint`` is declared.

    An integer may stand for a float, a truth value never for a number, a list for any sequence.
    """
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(fits(value, part) for part in parts)
    if origin is Literal:
        return value in parts
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return isinstance(value, Mapping)
    if origin is not None:
        return isinstance(value, list | tuple) and all(fits(v, parts[0]) for v in value)
    return _fits_plain(value, hint)


def _fits_plain(value: object, hint: Any) -> bool:
    if hint in (int, float):
        kinds = (int,) if hint is int else (int, float)
        return isinstance(value, kinds) and not isinstance(value, bool)
    if hint is Any:
        return True
    if hint in (None, type(None)):
        return value is None
    return isinstance(value, hint) if isinstance(hint, type) else True


def spell(hint: Any) -> str:
    """The annotation as a person would say it: ``int or 'auto'``."""
    if get_origin(hint) in (Union, UnionType):
        return " or ".join(spell(part) for part in get_args(hint))
    if get_origin(hint) is Literal:
        return " or ".join(map(repr, get_args(hint)))
    if hint is type(None):
        return "nothing"
    return _spell_plain(get_origin(hint) or hint, get_args(hint))


def _spell_plain(kind: Any, parts: tuple[Any, ...]) -> str:
    if isinstance(kind, type) and issubclass(kind, Mapping):
        return "a table"
    if kind in (list, tuple) and parts:
        return f"a list of {spell(parts[0])}"
    return kind.__name__ if isinstance(kind, type) else str(kind)
