"""The whole reproduction: measure what is missing, draw, write the page."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from lpcompare.benchmark.environment import capture
from lpcompare.files import replace_text
from lpcompare.reproduction.charts import draw_errors, draw_seconds
from lpcompare.reproduction.experiments import EXPERIMENTS
from lpcompare.reproduction.lab import Lab
from lpcompare.reproduction.page import render
from lpcompare.reproduction.pictures import draw_clusters, draw_curvature, draw_holes, draw_reduced
from lpcompare.reproduction.table import Table
from lpcompare.threads import thread_count
from lpcompare.types import PointCloud

Progress = Callable[[str, int, int], None]


def reproduce(
    clouds: Mapping[str, PointCloud],
    folder: Path,
    *,
    command: str,
    left_out: tuple[str, ...] = (),
    progress: Progress | None = None,
) -> Path:
    """Make every table and figure of the paper again.

    A folder that an earlier call left unfinished is taken up where it ended.

    Parameters
    ----------
    clouds : mapping of str to PointCloud
        The models by name.
    folder : Path
        Where tables, pictures and the page go; made if it does not exist.
    command : str
        The command line, for the page.
    left_out : tuple of str
        Why a model is missing, for the page.
    progress : callable, optional
        Called with (what, cases done, cases).

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        The folder holds tables that are not this command's.
    """
    lab, models = Lab(clouds), tuple(clouds)
    folder.mkdir(parents=True, exist_ok=True)
    tables = {e.name: Table(folder / f"{e.name}.csv", e.keys) for e in EXPERIMENTS}
    for experiment in EXPERIMENTS:
        cases = list(experiment.cases(models))
        measure = partial(experiment.measure, lab)
        for done, _ in enumerate(tables[experiment.name].fill(cases, measure), 1):
            _tell(progress, experiment.title, done, len(cases))
    _draw(lab, folder, tables, progress)
    made = _how(command, left_out)
    replace_text(folder / "made.json", json.dumps(made, indent=1) + "\n")
    page = folder / "README.md"
    replace_text(page, render({name: table.rows for name, table in tables.items()}, made))
    return page


def _tell(progress: Progress | None, what: str, done: int, total: int) -> None:
    if progress is not None:
        progress(what, done, total)


def _draw(lab: Lab, folder: Path, tables: dict[str, Table], progress: Progress | None) -> None:
    """The pictures that are not there yet; the two charts always, since rows may have been added."""
    for done, name in enumerate(lab.clouds, 1):
        for file, draw in _CLOUD_PICTURES.items():
            path = folder / f"{name}-{file}.png"
            if not path.exists():
                draw(lab, name, path)
        draw_seconds(tables["seconds"].rows, name, folder / f"{name}-fig8-seconds.png")
        draw_errors(tables["errors"].rows, name, folder / f"{name}-fig9-errors.png")
        _tell(progress, "Pictures", done, len(lab.clouds))


_CLOUD_PICTURES = {
    "fig4-clusters": draw_clusters,
    "fig5-curvature": draw_curvature,
    "fig6-reduced": draw_reduced,
    "holes": draw_holes,
}


def _how(command: str, left_out: tuple[str, ...]) -> dict[str, Any]:
    facts = capture(("lp_printed", "lp_density"), thread_count())
    memory = f"{facts['memory_mib'] / 1024:.0f} GiB"
    named = ("numpy", "scipy", "cvxpy", "highspy")
    return {
        "command": command,
        "date": facts["started"][:10],
        "commit": facts["commit"] or f"of release {facts['packages']['lpcompare']}",
        "machine": f"{facts['cpu']}, {facts['cores_allowed']} cores, {memory}, {facts['os']}",
        "versions": ", ".join(
            [f"Python {facts['python']}", *(f"{name} {facts['packages'][name]}" for name in named)]
        ),
        "left_out": list(left_out),
        "titles": {e.name: e.title for e in EXPERIMENTS},
    }
