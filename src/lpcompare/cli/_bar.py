"""A bar on stderr for work that reports (stage, done, total)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Callback = Callable[[str, int, int], None]


@contextmanager
def stage_bar(*, hidden: bool) -> Iterator[Callback]:
    """A callback that names the stage and its remaining time, where stderr is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    hidden = hidden or not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=hidden) as progress:
        task, shown = progress.add_task("starting", total=None), [""]

        def callback(stage: str, done: int, total: int) -> None:
            if stage != shown[0]:
                progress.reset(task, description=stage)
                shown[0] = stage
            progress.update(task, completed=done, total=total or None)

        yield callback
