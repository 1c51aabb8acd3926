"""``lpcompare list``: what there is, one line each; imports no method."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from typing import Annotated

import typer

_WIDTH = 100


def command(
    kind: Annotated[str, typer.Argument(help="methods, models or metrics; all three by default.")] = "",
) -> None:
    """List methods, models and metrics."""
    from lpcompare.errors import UnknownName

    parts: dict[str, Callable[[], dict[str, str]]] = {
        "methods": _methods,
        "models": _models,
        "metrics": _metrics,
    }
    if kind and kind not in parts:
        raise UnknownName("kind of list", kind, parts)
    for name in [kind] if kind else parts:
        if not kind:
            typer.echo(f"{name}:")
        typer.echo(_lines(parts[name]()))


def _lines(entries: dict[str, str]) -> str:
    width = max(map(len, entries), default=0) + 2
    return "\n".join(
        f"{name:<{width}}{textwrap.shorten(text, _WIDTH - width, placeholder='...')}"
        for name, text in entries.items()
    )


def _methods() -> dict[str, str]:
    from lpcompare.registry import METHODS

    return {name: _availability(METHODS.missing(name)) + METHODS.summary(name) for name in METHODS}


def _availability(missing: str) -> str:
    return "(not installed) " if missing else ""


def _metrics() -> dict[str, str]:
    from lpcompare.registry import METRICS

    return {name: METRICS.summary(name) for name in METRICS}


def _models() -> dict[str, str]:
    from lpcompare.models import model_names, model_summary

    return {name: model_summary(name) for name in model_names()}
