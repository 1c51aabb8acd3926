"""``lpcompare list``: what there is, one line each in a pipe, or all about one thing; imports no rival for a list."""

from __future__ import annotations

from typing import Annotated

import typer

from lpcompare.cli._complete import KINDS, things
from lpcompare.cli._say import complain, say


def command(
    what: Annotated[
        str,
        typer.Argument(
            metavar="[KIND | NAME]",
            help="methods, models, metrics, or one of their names.",
            autocompletion=things,
        ),
    ] = "",
) -> None:
    """List methods, models, metrics; explain one.

    Example: lpcompare list lp_uniform
    """
    from lpcompare.registry import METHODS, METRICS

    tables = {"methods": _methods, "models": _models, "metrics": _metrics}
    if what and what not in tables:
        say(_explain(what))
        return
    for kind in [what] if what else KINDS:
        if not what:
            say(f"{kind}:")
        say(_lines(tables[kind]()))
    for note in METHODS.notes + METRICS.notes:
        complain(note)


def _lines(entries: dict[str, str]) -> str:
    indent = max(map(len, entries), default=0) + 2
    return "\n".join(f"{name:<{indent}}{text}" for name, text in entries.items())


def _methods() -> dict[str, str]:
    from lpcompare.registry import METHODS

    return {name: _flags(name) + METHODS.summary(name) for name in METHODS}


def _flags(name: str) -> str:
    from lpcompare.registry import METHODS

    flags = ["not installed"] * bool(METHODS.missing(name)) + ["reading"] * METHODS.traits(name).reading
    return f"({', '.join(flags)}) " if flags else ""


def _metrics() -> dict[str, str]:
    from lpcompare.registry import METRICS

    return {name: METRICS.summary(name) for name in METRICS}


def _models() -> dict[str, str]:
    from lpcompare.models import model_names, model_summary

    return {name: model_summary(name) for name in model_names()}


def _explain(name: str) -> str:
    from lpcompare.errors import UnknownName
    from lpcompare.models import model_names, model_summary
    from lpcompare.registry import METHODS, METRICS

    if name in METHODS:
        return _explain_method(name)
    if name in METRICS:
        return _prose(METRICS.documentation(name))
    if name in model_names():
        return model_summary(name)
    raise UnknownName(
        "method, metric, model or kind of list", name, [*KINDS, *METHODS, *METRICS, *model_names()]
    )


def _prose(text: str) -> str:
    """A docstring with each paragraph in one line; what is indented stays as it is."""
    paragraphs = text.split("\n\n")
    return "\n\n".join(p if "\n " in p or p.startswith(" ") else p.replace("\n", " ") for p in paragraphs)


def _explain_method(name: str) -> str:
    """What a method is, needs and promises, and its settings with their defaults."""
    from lpcompare.registry import METHODS

    traits, missing = METHODS.traits(name), METHODS.missing(name)
    facts = {
        "wraps": traits.wraps,
        "source": traits.source,
        "licence": traits.licence,
        "needs": "a triangle mesh" if traits.needs_mesh else "points alone",
        "returns": "new points" if traits.moves_points else "a subset of the input",
        "count": "exact" if traits.exact_count else "near the one asked for",
        "order": "progressive: every prefix is a thinning" if traits.progressive else "",
        "comes from": METHODS.origin(name),
        "missing": missing,
    }
    lines = [_prose(METHODS.documentation(name)), ""]
    lines += [f"{key + ':':<12}{value}" for key, value in facts.items() if value]
    if not missing:
        settings = METHODS.settings(name)
        lines += ["settings:"] + [f"  {key} = {value!r}" for key, value in settings.items()]
        lines += ["  none"] * (not settings)
    return "\n".join(lines)
