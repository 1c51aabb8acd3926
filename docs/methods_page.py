"""The page of the methods, made from their own files."""

from __future__ import annotations

from lpcompare.registry import METHODS
from lpcompare.report.tables import markdown_table
from lpcompare.types import Traits

_METHODS = ("method", "what it does", "needs", "result", "count", "attributes", "licence")


def method_page() -> str:
    """The methods as Markdown: a table of flags, then what each one wraps and where it comes from.

    Returns
    -------
    str
        Default methods first, those behind an extra after them. No method is imported.
    """
    names = sorted(METHODS, key=lambda name: (bool(METHODS.traits(name).extra), name))
    rows = [(f"`{name}`", METHODS.summary(name), *_flags(METHODS.traits(name))) for name in names]
    rows = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    lines = [
        "# Methods",
        "",
        "Made from the methods' own files by `docs/methods_page.py`.",
    ]
    lines += ["", *markdown_table(_METHODS, rows, "---"), "", "## What each one wraps, and its source", ""]
    lines += [_entry(name, METHODS.traits(name)) for name in names]
    return "\n".join([*lines, ""])


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


def _entry(name: str, traits: Traits) -> str:
    return f"- `{name}`: {traits.wraps}. {traits.source}".rstrip(". ") + "."
