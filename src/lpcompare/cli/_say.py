"""Texts for people: on a terminal, lines break between words; in a file or a pipe they stay whole."""

from __future__ import annotations

import re
import sys
import textwrap
from shutil import get_terminal_size

import typer


def say(text: str, *, err: bool = False) -> None:
    """Print a text; on a terminal, what follows in a broken line stands below its first text."""
    stream = sys.stderr if err else sys.stdout
    typer.echo(broken(text, get_terminal_size().columns) if stream.isatty() else text, err=err)


def broken(text: str, width: int) -> str:
    """The text in lines of ``width`` at most; names, paths and commands stay whole."""
    return "\n".join(_broken_line(line, width) for line in text.split("\n"))


def _broken_line(line: str, width: int) -> str:
    start = re.match(r" *(\S+ {2,})?", line)
    indent = " " * start.end() if start and start.end() < width // 2 else ""
    return textwrap.fill(
        line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
