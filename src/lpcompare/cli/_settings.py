"""Settings of methods from the words of ``--set``."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from typing import Any

from lpcompare.errors import InputError
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
        if not (equals and dot and method and name and word.isprintable()):
            raise InputError(f"--set {word!r} is not of the form method.setting=value.")
        METHODS.check_names([method])
        if method not in methods:
            raise InputError(f"--set {word!r}: {method} is not part of this run ({', '.join(methods)}).")
        parsed.setdefault(method, {})[name] = _value(text.strip())
    for method, chosen in parsed.items():
        METHODS.check_settings(method, chosen)
    return parsed


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, KeyError, RecursionError):
        return text
