"""Make every study of this folder again, one after the other.

Run it from the root of the repository::

    python reports/make.py [--models FOLDER] [--only NAME ...]

FOLDER holds the folders ``upstream`` and ``scans``; where it is not given, it is the one above ``LPCOMPARE_MODELS``.
A step that was made from the commit that is checked out is passed over; a run that was stopped is continued.
``reports/local`` holds the runs; ``reports/made.json`` says of every step with which commit, when, on which machine
and in how many seconds it was made.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from lpcompare.benchmark.environment import capture

ROOT = Path(__file__).resolve().parents[1]
LOCAL, MADE = ROOT / "reports" / "local", ROOT / "reports" / "made.json"
DATA = ("run.json", "records.csv")
KEPT = {**dict.fromkeys(("bunny", "methods", "robustness"), (*DATA, "README.md")), "seeds": DATA}
"""What is committed of the folder of each run."""

SCANS = ("lidar-room-56159", "rangemap-lato315-62702")

Words = list[str]


def run(name: str, *words: str) -> list[Words]:
    """The commands of a study that ``lpcompare run`` makes."""
    folder = f"reports/local/{name}"
    resume = ["--resume"] if (ROOT / folder / "run.json").exists() else []
    cli = [sys.executable, "-m", "lpcompare.cli"]
    return [
        [*cli, "run", *words, "--out", folder, *resume],
        [*cli, "report", "--page", "--reference", "poisson_disk", folder],
    ]


def study(name: str, *clouds: str, jobs: int = 1) -> list[Words]:
    """The commands of a study that has a file, on these names and files."""
    words = [word for cloud in clouds for word in ("--model", cloud)]
    return run(name, "--study", f"reports/{name}/study.toml", *words, "--jobs", str(jobs))


def steps(models: Path) -> dict[str, list[Words]]:
    """The commands of every step, in order."""
    python = [sys.executable]
    suites = [f"tests/benchmarks/test_{name}.py" for name in ("stages", "methods", "metrics")]
    measure = [*python, "-m", "pytest", "-q"]
    scans = [f"{models}/upstream/stanford-bunny.obj", f"{models}/scans/max-planck-45045.ply"]
    sweep = [
        "--sweep",
        "--reductions",
        "0.7",
        "0.9",
        "0.97",
        "--methods",
        "lp_uniform",
        "lp_placed",
        "poisson_disk",
    ]
    uniform = [*python, "reports/uniform/make.py", "--models", str(models), "--out", "reports/uniform"]
    scanned = [f"{models}/scans/{scan}.ply" for scan in SCANS]
    return {
        "bunny": run("bunny", "--model", "bunny"),
        "uniform": [uniform, [*uniform, *sweep]],
        "pauly": [[*python, "reports/pauly/make.py", "--models", str(models)]],
        "paper": [
            [
                *python,
                "reports/paper/make.py",
                *(word for scan in scans for word in ("--model", scan)),
                *("--out", "reports/paper"),
            ]
        ],
        "methods": study("methods", "fandisk", "stanford-bunny", "igea", *scanned, jobs=2),
        "benchmarks": [
            [*measure, *suites, "--benchmark-json=reports/benchmarks/baseline.json"],
            *(
                [
                    *measure,
                    f"tests/benchmarks/test_{suite}.py",
                    f"--benchmark-json=reports/benchmarks/{file}.json",
                ]
                for suite, file in (("lp_filter", "filter"), ("uniform", "uniform"))
            ),
            [*python, "reports/benchmarks/draw.py"],
        ],
        "robustness": study("robustness", "fandisk", "stanford-bunny", *scanned),
        "seeds": study("seeds", "stanford-bunny", "fandisk", scanned[0], jobs=2),
        "pictures": [
            [*python, "reports/pictures/draw.py", "reports/local/bunny"],
            [*python, "reports/methods/draw.py"],
        ],
        "texts": [[*python, "docs/make.py"]],
    }


def make(name: str, commands: list[Words], models: Path) -> None:
    """Run the commands of a step, and keep what is committed of it."""
    for words in commands:
        environment = {**os.environ, "LPCOMPARE_MODELS": str(models / "upstream")}
        ended = subprocess.run(words, cwd=ROOT, check=False, env=environment).returncode
        if ended and (ended, words[1:4]) != (
            1,
            ["-m", "lpcompare.cli", "run"],
        ):  # 1: cases failed, which are rows
            raise subprocess.CalledProcessError(ended, words)
    for file in KEPT.get(name, ()):
        text = (LOCAL / name / file).read_text(encoding="utf-8")
        kept = ROOT / "reports" / name / file
        kept.write_text(text.replace(f"{models}/scans/", ""), encoding="utf-8", newline="")


def timed(name: str, commands: list[Words], models: Path, made: dict[str, Any]) -> None:
    """Make a step and note it; of one that is stopped, the seconds are noted, and those of its end are added."""
    facts, head = capture((), os.cpu_count() or 1), commit()
    noted, began = made.get(name, {}), time.monotonic()
    before = noted["seconds"] if noted.get("stopped") == head else 0
    ended = {"stopped": head}
    try:
        make(name, commands, models)
        ended = {"commit": head}
    finally:
        machine = f"{facts['cpu']}, {facts['cores_allowed']} cores, {facts['memory_mib'] / 1024:.0f} GiB"
        seconds = round(before + time.monotonic() - began)
        made[name] = {**ended, "date": facts["started"][:10], "machine": machine, "seconds": seconds}
        MADE.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
        print(f"{name}: {seconds} s", flush=True)


def commit() -> str:
    """The commit that is checked out."""
    words = ["git", "rev-parse", "HEAD"]
    return subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()


def main() -> None:
    """Make the steps that the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    upstream = os.environ.get("LPCOMPARE_MODELS")
    above = Path(upstream).resolve().parent if upstream else None
    parser.add_argument("--models", type=Path, default=above, required=above is None)
    parser.add_argument("--only", nargs="*", help="names of steps; these are made in any case")
    given = parser.parse_args()
    known = steps(given.models.resolve())
    if unknown := set(given.only or ()) - set(known):
        parser.error(f"no step is called {', '.join(sorted(unknown))}; known: {', '.join(known)}")
    made = json.loads(MADE.read_text()) if MADE.exists() else {}
    for name in given.only or [n for n in known if made.get(n, {}).get("commit") != commit()]:
        timed(name, known[name], given.models.resolve(), made)


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"make.py: {' '.join(map(str, error.cmd))} ended with {error.returncode}")
