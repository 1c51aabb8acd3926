"""Make every table and figure of Leal et al. (2017) again, and hold its statements against them.

    python reports/paper/make.py [--model NAME] [--out FOLDER]

A folder that was left unfinished is continued from the same commit, and made anew from another.
The default models are the paper's two, if they can be had.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(
    0, str(Path(__file__).resolve().parents[2])
)  # the scripts of this folder are no package of the wheel

from reports.paper.charts import draw_errors, draw_seconds
from reports.paper.experiments import EXPERIMENTS
from reports.paper.lab import Lab
from reports.paper.page import render
from reports.paper.pictures import draw_clusters, draw_curvature, draw_holes, draw_reduced
from reports.paper.table import Table

from lpcompare.benchmark.environment import capture
from lpcompare.errors import LpcompareError, ModelDataError
from lpcompare.files import replace_text
from lpcompare.models import load_model
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

    A folder that an earlier call from the same commit left unfinished is taken up where it ended.

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
    made = _begin(folder, _how(command, left_out))
    tables = {e.name: Table(folder / f"{e.name}.csv", e.keys) for e in EXPERIMENTS}
    for experiment in EXPERIMENTS:
        cases = list(experiment.cases(models))
        measure = partial(experiment.measure, lab)
        for done, _ in enumerate(tables[experiment.name].fill(cases, measure), 1):
            _tell(progress, experiment.title, done, len(cases))
    _draw(lab, folder, tables, progress)
    page = folder / "README.md"
    replace_text(page, render({name: table.rows for name, table in tables.items()}, made))
    return page


def _begin(folder: Path, made: dict[str, Any]) -> dict[str, Any]:
    """Empty a folder that was made from another commit, and write how it is made now."""
    before = folder / "made.json"
    old = json.loads(before.read_text(encoding="utf-8"))["commit"] if before.exists() else made["commit"]
    if old.rstrip("+") != made["commit"].rstrip(
        "+"
    ):  # what is written here makes the tree dirty, which is "+"
        for path in (*folder.glob("*.csv"), *folder.glob("*.png")):
            path.unlink()
    replace_text(before, json.dumps(made, indent=1) + "\n")
    return made


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


_PAPER_MODELS = ("stanford-bunny", "max-planck")


def load(names: list[str] | None) -> tuple[dict[str, PointCloud], list[str]]:
    """The clouds by name; of the paper's own models, one that cannot be had is left out and said so."""
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


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Make the tables and figures of the paper again.")
    parser.add_argument("--model", action="append", help="a model's name, or a file")
    parser.add_argument("--out", type=Path, default=Path("reports/local/paper"), help="folder of the page")
    given = parser.parse_args()
    clouds, left_out = load(given.model)
    named = " ".join(f"--model {Path(name).name}" for name in given.model or clouds)
    page = reproduce(
        clouds,
        given.out,
        command=f"python reports/paper/make.py {named}",
        left_out=tuple(left_out),
        progress=lambda what, done, total: print(f"{what}: {done} of {total}", file=sys.stderr),
    )
    print(f"The page is {page}.")


if __name__ == "__main__":
    try:
        main()
    except LpcompareError as error:
        sys.exit(f"make.py: {error}")
