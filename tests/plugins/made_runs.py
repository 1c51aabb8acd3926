"""Run folders for the tests of the report: real errors on a small cloud, in the harness's layout."""

import json
from pathlib import Path

import numpy as np
import pytest

from lpcompare.benchmark.record import SCHEMA_VERSION, Record
from lpcompare.benchmark.run_folder import file_name
from lpcompare.io.arrays import save_arrays
from lpcompare.metrics.comparison import Comparison
from lpcompare.metrics.hausdorff import hausdorff
from lpcompare.metrics.plane_error import plane_error


def dented_sphere(n=1500, seed=0):
    """Points of a sphere with waves, so that the error differs from place to place."""
    directions = np.random.default_rng(seed).normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions * (1 + 0.1 * np.sin(6 * directions[:, :1]))


def random_rows(points, count, rng):
    """A subset, drawn at random."""
    return np.sort(rng.choice(len(points), count, replace=False))


def first_rows(points, count, rng):
    """A subset that leaves a side of the cloud empty."""
    return np.sort(np.argsort(points[:, 2])[:count])


def moved_points(points, count, rng):
    """New points."""
    return points[random_rows(points, count, rng)] * 1.001


METHODS = {"random_sample": random_rows, "first_rows": first_rows, "moved_points": moved_points}
RUNTIMES = {"random_sample": 0.001, "first_rows": 0.01, "moved_points": 0.1}


class MadeRun:
    """A run being written: add cases, then write."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.records, self.inputs = folder, [], {}
        (folder / "clouds").mkdir(parents=True)

    def model(self, name, points, faces=None):
        file = f"clouds/{file_name(name)}.npz"
        arrays = {"points": points} | ({} if faces is None else {"faces": faces})
        save_arrays(self.folder / file, arrays)
        self.inputs[file_name(name)] = {"file": file, "model": name, "n_points": len(points), "sha256": "0"}
        self.points = {**getattr(self, "points", {}), name: points}

    def case(self, model, method, reduction, repeat=0, label=None, marks=None):
        points, target = self.points[model], round((1 - reduction) * len(self.points[model]))
        chosen = METHODS[method](points, target, np.random.default_rng(repeat))
        rows = chosen if chosen.ndim == 1 else None
        kept = points[rows] if rows is not None else chosen
        comparison = Comparison(points, kept)
        errors = comparison.plane_errors(8).astype(np.float32)
        label = label or method
        file = f"clouds/{file_name(model)}~{file_name(label)}~{reduction:g}~s0.npz" if repeat == 0 else ""
        if file:
            arrays = {"points": kept, "plane_errors": errors} | ({} if rows is None else {"indices": rows})
            save_arrays(self.folder / file, arrays | (marks or {}))
        runtime = RUNTIMES[method] * (1 + 0.1 * repeat)
        self.records.append(
            Record(model, label, reduction, len(points), target, 0, repeat, "ok", n_output=len(kept),
                   runtime_s=runtime, peak_memory_mib=80.0, subset=rows is not None, needs_mesh=False,
                   settings={"n_neighbors": 8}, timings={"search": runtime / 2, "choice": runtime / 4},
                   metrics=plane_error(comparison) | hausdorff(comparison), cloud=file)
        )  # fmt: skip

    def trouble(self, model, method, reduction, status, message):
        n = len(self.points[model])
        target = round((1 - reduction) * n)
        self.records.append(Record(model, method, reduction, n, target, 0, 0, status, message))

    def write(self):
        document = {
            "schema_version": SCHEMA_VERSION,
            "complete": True,
            "plan": {"models": list(self.inputs), "repeats": 1},
            "environment": {
                "command": "lpcompare run --model made",
                "cpu": "a processor",
                "packages": {"numpy": "2"},
            },
            "inputs": self.inputs,
            "records": [record.to_dict() for record in self.records],
        }
        (self.folder / "run.json").write_text(json.dumps(document), encoding="utf-8")
        return self.folder


@pytest.fixture
def new_run(tmp_path):
    """An empty run to add cases to."""
    return MadeRun(tmp_path / "run")


@pytest.fixture(scope="session")
def plain_run(tmp_path_factory):
    """Two reductions, two repeats, three methods, and one row of each trouble."""
    made = MadeRun(tmp_path_factory.mktemp("plain") / "run")
    made.model("dented", dented_sphere())
    for repeat in (0, 1):
        for reduction in (0.8, 0.9):
            for method in METHODS:
                made.case("dented", method, reduction, repeat)
    made.trouble("dented", "crasher", 0.8, "failed", "The process died of signal 6 (SIGABRT).")
    made.trouble("dented", "sleeper", 0.8, "timeout", "Stopped after 300 s.")
    made.trouble("dented", "mesher", 0.8, "skipped", "The model has no faces.")
    return made.write()
