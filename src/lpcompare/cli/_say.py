"""Texts for people: nothing in them commands a terminal, and there lines break between words.

Names of files and texts of records may hold anything. In a file or a pipe lines stay whole.
"""

from __future__ import annotations

import re
import sys
import textwrap
from shutil import get_terminal_size

import typer

from lpcompare.errors import printable

_LONGEST_LINE = 100_000


def say(text: str, *, err: bool = False) -> None:
    """Print a text without its control characters; what follows in a broken line stands below its first text."""
    stream = sys.stderr if err else sys.stdout
    text = "\n".join(printable(line, _LONGEST_LINE) for line in text.split("\n"))
    typer.echo(broken(text, get_terminal_size().columns) if stream.isatty() else text, err=err)


def complain(sentence: str) -> None:
    """Print what is wrong on standard error, as one line."""
    say(f"lpcompare: {printable(sentence, _LONGEST_LINE)}", err=True)


def broken(text: str, width: int) -> str:
    """The text in lines of ``width`` at most; names, paths and commands stay whole."""
    return "\n".join(_broken_line(line, width) for line in text.split("\n"))


def _broken_line(line: str, width: int) -> str:
    start = re.match(r" *(\S+ {2,})?", line)
    indent = " " * start.end() if start and start.end() < width // 2 else ""
    return textwrap.fill(
        line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
