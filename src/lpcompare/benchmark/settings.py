"""Settings of methods from outside: ``lp_density.n_clusters=25``, checked against the signature."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from typing import Any, get_type_hints

from lpcompare.benchmark.hints import fits, spell
from lpcompare.errors import InputError, UnknownName
from lpcompare.registry import METHODS


def parse_assignments(assignments: Iterable[str], methods: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Settings per method, from ``method.setting=value`` words.

    Values are read as TOML (``25``, ``0.5``, ``true``, ``"text"``); anything else is text.

    Raises
    ------
    InputError
        A word that is not an assignment, a method that is not part of the run, or a value of the wrong type.
    UnknownName
        No such method or setting.
    """
    methods = tuple(methods)
    parsed: dict[str, dict[str, Any]] = {}
    for word in assignments:
        target, equals, text = word.partition("=")
        method, dot, name = target.strip().partition(".")
        if not (equals and dot and method and name):
            raise InputError(f"--set {word!r} is not of the form method.setting=value.")
        if method not in METHODS:
            raise UnknownName("method", method, METHODS)
        if method not in methods:
            raise InputError(f"--set {word!r}: {method} is not part of this run ({', '.join(methods)}).")
        parsed.setdefault(method, {})[name] = _value(text.strip())
    for method, chosen in parsed.items():
        check_settings(method, chosen)
    return parsed


def check_settings(method: str, chosen: Mapping[str, Any]) -> None:
    """Refuse settings that the method does not have, or values of another type.

    Raises
    ------
    UnknownName, InputError, Unavailable
    """
    if not chosen:
        return
    known = METHODS.settings(method)
    hints = get_type_hints(METHODS.get(method))
    if not known:
        raise InputError(f"{method} has no settings; leave out {', '.join(chosen)}.")
    for name, value in chosen.items():
        if name not in known:
            raise UnknownName(f"setting of {method}", name, known)
        if not fits(value, hints.get(name, Any)):
            raise InputError(
                f"{method}.{name} is {value!r}, a {type(value).__name__}; "
                f"it must be {spell(hints[name])} (default {known[name]!r})."
            )


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, KeyError):
        return text
