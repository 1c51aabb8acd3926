"""``lpcompare compare``: differences between runs, with intervals, or between the methods of one."""

from __future__ import annotations

from pathlib import Path
from shutil import get_terminal_size
from typing import Annotated

import typer

from lpcompare.cli._say import say


def command(
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN", help="Folders of runs; the first is what the others are compared with."
        ),
    ],
) -> None:
    """Compare runs of the same inputs, or the methods of one.

    The first run is what the others are compared with. An interval says what chance alone may do.

    Example: lpcompare compare reports/local/before reports/local/after
    """
    from lpcompare.benchmark.record import load_run
    from lpcompare.report.comparison import format_comparison, format_methods
    from lpcompare.report.tables import NARROW

    width = max(NARROW, get_terminal_size((NARROW, 24)).columns)
    first, *others = [load_run(path) for path in runs]
    texts = [format_comparison(first, other, width) for other in others] or [format_methods(first, width)]
    say("\n\n".join(texts))
