"""What is printed: names of files and texts of records may hold anything, also commands to a terminal."""

from __future__ import annotations

import typer

from lpcompare.errors import printable

_LONGEST_LINE = 100_000


def say(text: str, *, err: bool = False) -> None:
    """Print lines without their control characters."""
    typer.echo("\n".join(printable(line, _LONGEST_LINE) for line in text.split("\n")), err=err)


def complain(sentence: str) -> None:
    """Print what is wrong, in one line on standard error."""
    typer.echo(f"lpcompare: {printable(sentence, _LONGEST_LINE)}", err=True)
