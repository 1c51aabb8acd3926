"""Many methods that misbehave, side by side and alone: each costs its own row, honest results stay as they are."""

import os
import random
import shutil
import sys
from pathlib import Path

import numpy as np
import psutil
import pytest

from lpcompare.benchmark.record import load_run

sys.path.insert(0, str(Path(__file__).parent))
from deeds import CALIBRATIONS, DEEDS, source

HONEST = ("random_sample", "farthest_point", "stratified_sample")
LIMITS = ["--reduction", 0.8, "--memory-limit", 1000, "--threads", 1]


@pytest.fixture(scope="module")
def run(lpcompare, cloud_file, plugin_environment, tmp_path_factory):
    """Run methods, the misbehaving ones among them, in a folder; by ``command``."""
    site = tmp_path_factory.mktemp("adversaries")
    for name in DEEDS:
        (site / f"{name}.py").write_text(source(name))
    info = site / "adversaries-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: adversaries\nVersion: 1.0\n")
    lines = "".join(f"{name} = {name}\n" for name in DEEDS)
    (info / "entry_points.txt").write_text(f"[lpcompare.methods]\n{lines}")
    before = plugin_environment["PYTHONPATH"]
    plugin_environment["PYTHONPATH"] = f"{before}{os.pathsep}{site}"

    def run(folder, methods, *more, command=lpcompare):
        words = [word for name in methods for word in ("--method", name)]
        words += [*LIMITS, "--out", folder, *more]
        done = command("run", "--model", cloud_file, *words, timeout=3000)
        assert done.returncode == int(any(m in DEEDS for m in methods) and not _all_ok(folder)), done.stderr
        assert done.stderr == ""
        assert "\x1b" not in done.stdout
        return load_run(folder)

    yield run
    plugin_environment["PYTHONPATH"] = before


def _all_ok(folder):
    return all(record.status == "ok" for record in load_run(folder).records)


@pytest.fixture(scope="module")
def alone(run, tmp_path_factory):
    """The honest methods without the others."""
    return run(tmp_path_factory.mktemp("honest") / "run", HONEST)


@pytest.fixture(scope="module")
def together(run, program, alone, tmp_path_factory):
    """All of them, the honest ones at the beginning, in the middle and at the end; nobody ends what they leave.

    The honest run goes first: it fills the cache of compiled kernels, which would count against the limit.
    """
    names = list(DEEDS)
    middle = len(names) // 2
    order = [HONEST[0], *names[:middle], HONEST[1], *names[middle:], HONEST[2]]
    folder = tmp_path_factory.mktemp("together") / "run"
    return run(folder, order, "--jobs", 2, "--time-limit", 15, command=program)


@pytest.mark.parametrize("name", DEEDS)
def test_each_has_its_row(together, name):
    check_row(together, name)


def check_row(run, name):
    _, status, message = DEEDS[name]
    (record,) = [r for r in run.records if r.method == name]
    assert status in (record.status, "any"), record.message
    assert record.message.startswith(message), record.message
    assert len(record.message) <= 1400
    assert (record.calibration_s is not None) == (name in CALIBRATIONS and record.runtime_s is not None)


def test_the_honest_results_are_equal_to_the_bit(together, alone):
    assert together.complete
    check_honest(together, alone)


def check_honest(run, alone):
    for expected in alone.records:
        (record,) = [r for r in run.records if r.method == expected.method]
        assert record.status == "ok", record.message
        assert record.points_sha256 == expected.points_sha256
        assert record.metrics == expected.metrics
        one, other = np.load(run.folder / record.cloud), np.load(alone.folder / expected.cloud)
        assert all(np.array_equal(one[name], other[name]) for name in other)


def test_nothing_is_left_behind(together):
    inside = [p.info["cwd"] for p in psutil.process_iter(["cwd"]) if p.info["cwd"]]
    assert not [folder for folder in inside if folder.startswith(str(together.folder))]
    assert not (together.folder / ".work").exists()
    assert not list(together.folder.rglob("pickled"))


def test_a_resumed_run_takes_everything_over(together, run):
    methods = dict.fromkeys(record.method for record in together.records)
    again = run(together.folder, methods, "--jobs", 2, "--time-limit", 15, "--resume")
    assert again.records == together.records


def test_alone_with_an_honest_method_each_has_its_row(run, alone, tmp_path, request):
    chosen = list(DEEDS) if request.config.getoption("--long") else random.Random(15).sample(list(DEEDS), 3)
    for name in chosen:
        done = run(tmp_path / name, [HONEST[0], name, *HONEST[1:]], "--time-limit", 15)
        check_row(done, name)
        check_honest(done, alone)
        shutil.rmtree(tmp_path / name)
