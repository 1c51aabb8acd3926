"""Lines of text in columns, at most 100 wide."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

from lpcompare.benchmark.record import Record

WIDTH = 100


def align(rows: Sequence[Sequence[str]], left: frozenset[int] = frozenset({0})) -> list[str]:
    """Rows as lines of aligned columns; the columns in ``left`` flush left, the others right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    cells = (
        [c.ljust(w) if i in left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        for row in rows
    )
    return ["  ".join(row).rstrip() for row in cells]


def notes(records: Iterable[Record]) -> list[str]:
    """What the records have to say, each sentence once."""
    sentences = dict.fromkeys(f"{r.variant}: {r.message.strip()}" for r in records if r.message)
    return [
        line
        for note in sentences
        for line in textwrap.wrap(note, WIDTH - 2, initial_indent="  ", subsequent_indent="    ")
    ]


def cut(name: str, width: int = 30) -> str:
    """A name that fits a column; a longer one ends in two dots."""
    return name if len(name) <= width else f"{name[: width - 2]}.."
