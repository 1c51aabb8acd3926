"""The page of methods: what each one wraps, needs, loses and promises, read from the methods' own files."""

from __future__ import annotations

from collections.abc import Iterator

from lpcompare.registry import METHODS, Registry
from lpcompare.types import Traits

_HEADER = ("method", "what it does", "needs", "result", "count", "attributes", "licence")


def method_page(methods: Registry = METHODS) -> str:
    """The methods as Markdown: a table of flags, then what each one wraps and where it comes from.

    Parameters
    ----------
    methods : Registry, optional

    Returns
    -------
    str
        Default methods first, those behind an extra after them. No method is imported.
    """
    return "\n".join(
        [
            "# Methods",
            "",
            "Made from the methods' own files by `lpcompare.report.method_table.method_page()`.",
            "",
            *_table(methods),
            "",
            "## What each one wraps, and its source",
            "",
            *(_entry(name, methods) for name in _ordered(methods)),
            "",
        ]
    )


def _ordered(methods: Registry) -> list[str]:
    return sorted(methods, key=lambda name: (bool(methods.traits(name).extra), name))


def _table(methods: Registry) -> Iterator[str]:
    yield _row(_HEADER)
    yield _row(("---",) * len(_HEADER))
    for name in _ordered(methods):
        yield _row((f"`{name}`", methods.summary(name), *_flags(methods.traits(name))))


def _flags(traits: Traits) -> tuple[str, ...]:
    """One cell per flag, in the order of the header."""
    needs = ["mesh"] * traits.needs_mesh
    if traits.extra:
        needs.append(f"`lpcompare[{traits.extra}]`")
    return (
        ", ".join(needs) or "points",
        "new points" if traits.moves_points else "subset",
        "exact" if traits.exact_count else "near",
        "kept" if traits.keeps_attributes else "lost",
        traits.licence,
    )


def _entry(name: str, methods: Registry) -> str:
    traits = methods.traits(name)
    return f"- `{name}`: {traits.wraps}. {traits.source}".rstrip(". ") + "."


def _row(cells: tuple[str, ...]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
