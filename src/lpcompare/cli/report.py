"""``lpcompare report``: a finished run as a page, and as figures, tables or a MeshLab project."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lpcompare.cli import _complete
from lpcompare.cli._say import say


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or its run.json.")],
    *,
    out: Annotated[
        Path | None, typer.Option(help="The page. Default: report.html in the run's folder.")
    ] = None,
    reference: Annotated[
        str,
        typer.Option(
            help="Method that ratios are taken to. Default: poisson_disk.", autocompletion=_complete.methods
        ),
    ] = "",
    figures: Annotated[
        bool, typer.Option("--figures", help="Charts and clouds as SVG, PDF and PNG.")
    ] = False,
    latex: Annotated[bool, typer.Option("--latex", help="Tables for LaTeX (booktabs).")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="The same tables in Markdown.")] = False,
    page: Annotated[
        bool, typer.Option("--page", help="README.md: all metrics against the reference.")
    ] = False,
    csv: Annotated[bool, typer.Option("--csv", help="One row per model, method and reduction.")] = False,
    meshlab: Annotated[bool, typer.Option("--meshlab", help="A MeshLab project, quality = error.")] = False,
) -> None:
    """Draw a finished run again, as files.

    Nothing is computed anew: the folder of the run has all of it.

    Example: lpcompare report reports/local/bunny --csv --figures
    """
    from lpcompare.benchmark.record import load_run
    from lpcompare.report.page import write_page

    loaded = load_run(run)
    written = [write_page(run, out, reference=reference)]
    if figures:
        from lpcompare.report.figures import write_figures

        written += write_figures(loaded, loaded.folder / "figures", reference)
    if latex:
        from lpcompare.report.tables import write_latex

        written.append(write_latex(loaded, loaded.folder / "tables.tex"))
    if markdown:
        from lpcompare.report.tables import write_markdown

        written.append(write_markdown(loaded, loaded.folder / "tables.md"))
    if page:
        from lpcompare.report.page_markdown import write_study_page

        written.append(write_study_page(loaded, loaded.folder / "README.md", reference))
    if csv:
        from lpcompare.report.tables import write_csv

        written.append(write_csv(loaded, loaded.folder / "cells.csv"))
    if meshlab:
        from lpcompare.report.meshlab_project import write_project

        written += write_project(loaded, loaded.folder / "meshlab")
    for path in written:
        say(str(path))
