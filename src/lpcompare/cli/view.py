"""``lpcompare view``: a point cloud or a run in 3D, in the browser."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from lpcompare.cli import _complete
from lpcompare.cli._say import say

RUN_FILE = "run.json"


def command(
    target: Annotated[
        str,
        typer.Argument(
            metavar="FILE|RUN",
            help="A file, a model's name, or a run's folder.",
            autocompletion=_complete.models,
        ),
    ],
    *,
    out: Annotated[
        Path | None, typer.Option(help="The page to write. Default: in the temporary folder.")
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page, where there is a screen.")] = True,
    serve: Annotated[
        bool, typer.Option("--serve", help="Serve the page of a run; clouds are sent when they are shown.")
    ] = False,
    port: Annotated[int, typer.Option(help="Port of --serve. Default: any that is free.")] = 0,
) -> None:
    """Show a point cloud or a run in the browser.

    Without a screen it says where the page is.

    Examples: lpcompare view scan.laz | lpcompare view reports/local/bunny --serve
    """
    if serve:
        _serve(target, port, browser=browser)
        return
    page = _write_page(target, out)
    shown = browser and _has_screen() and webbrowser.open(page.resolve().as_uri())
    say(f"{'Opened' if shown else 'The page is'} {page}")


def _write_page(target: str, out: Path | None) -> Path:
    from lpcompare.benchmark.run_folder import file_name

    if out is not None:
        return _show(target, out)
    folder = Path(tempfile.mkdtemp(prefix="lpcompare-"))
    try:
        return _show(target, folder / f"{file_name(Path(target).stem)}.html")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _show(target: str, out: Path) -> Path:
    """Write the page of a run, a file or a model."""
    from lpcompare.benchmark.runner import load_models
    from lpcompare.report.page import write_page, write_view

    if _is_run(Path(target)):
        return write_page(target, out)
    (cloud,) = load_models([target], tell=lambda sentence: say(sentence, err=True)).values()
    return write_view(cloud, out)


def _serve(target: str, port: int, *, browser: bool) -> None:
    """Serve until the user stops it."""
    from lpcompare.benchmark.record import load_run
    from lpcompare.errors import InputError
    from lpcompare.report.serve import HOST, make_server

    if not _is_run(Path(target)):
        raise InputError(f"{target} is not the folder of a run; --serve shows runs, a file needs no server.")
    with make_server(load_run(target), port=port) as server:
        address = f"http://{HOST}:{server.server_port}/"
        say(f"The page is {address} until you stop this command (Ctrl-C).")
        if browser and _has_screen():
            webbrowser.open(address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            say("")


def _is_run(path: Path) -> bool:
    return path.name == RUN_FILE or (path / RUN_FILE).is_file()


def _has_screen() -> bool:
    """Without one, the standard library would start a browser for text in this terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
