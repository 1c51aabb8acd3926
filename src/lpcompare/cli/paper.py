"""``lpcompare paper``: every table and figure of Leal et al. (2017), measured again and audited."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lpcompare.errors import ModelDataError

if TYPE_CHECKING:
    from lpcompare.types import PointCloud

_PAPER_MODELS = ("stanford-bunny", "max-planck")


def command(
    *,
    model: Annotated[
        list[str] | None,
        typer.Option(
            "--model", help="A model's name, or a file. Default: the paper's two, if they can be had."
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option(help="Folder of the page; one that was left unfinished is continued.")
    ] = Path("reports/local/paper"),
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress.")] = False,
) -> None:
    """Make the tables and figures of the paper again, and hold its statements against them."""
    from lpcompare.cli._bar import stage_bar
    from lpcompare.reproduction.reproduce import reproduce

    clouds, left_out = _load(model)
    named = " ".join(f"--model {Path(name).name}" for name in model or clouds)
    with stage_bar(shown=not quiet and sys.stderr.isatty()) as progress:
        page = reproduce(
            clouds, out, command=f"lpcompare paper {named}", left_out=tuple(left_out), progress=progress
        )
    typer.echo(f"The page is {page}.")


def _load(names: list[str] | None) -> tuple[dict[str, PointCloud], list[str]]:
    """The clouds by name; of the paper's own models, one that cannot be had is left out and said so."""
    from lpcompare.models import load_model

    clouds, left_out = {}, []
    for name in names or _PAPER_MODELS:
        try:
            cloud = load_model(name)
            clouds[cloud.name] = cloud
        except ModelDataError as error:
            if names or name == _PAPER_MODELS[0]:
                raise
            left_out.append(str(error))
    return clouds, left_out
