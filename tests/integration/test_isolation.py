"""Methods that hang, abort, eat memory, print, lie: each is a row, and the other rows do not notice."""

import signal
import subprocess
import sys
import time

import numpy as np
import psutil
import pytest

from lpcompare.benchmark.record import load_run

NAUGHTY = {
    "hangs": ("timeout", "Killed in the warm-up after 10 s, the time limit."),
    "aborts": (
        "failed",
        "The process crashed with SIGABRT in the warm-up. Last output: assertion failed: n > 0",
    ),
    "crashes": ("failed", "The process crashed with SIGSEGV in the warm-up."),
    "eats_memory": ("failed", "Out of memory (limit 1024 MiB)"),
    "writes_to_stdout": ("ok", ""),
    "returns_too_many": ("failed", "The method returned 101 points and promises exactly 100."),
    "returns_nan": ("failed", "1 of the 100 points returned are NaN or infinite."),
    "changes_its_input": ("failed", "The method changed its input."),
    "raises": ("failed", "ValueError: no luck today."),
    "exits": ("failed", "The process ended with exit code 3 and no result in the warm-up."),
    "lies_about_rows": ("failed", "The points are not the rows of the input that the indices name."),
    "declines": ("skipped", "This method works on Tuesdays only."),
}


def run_methods(command, cloud_file, out, methods):
    words = [word for name in methods for word in ("--method", name)]
    done = command(
        "run", "--model", cloud_file, *words, "--reduction", 0.8, "--time-limit", 10, "--memory-limit", 1024,
        "--out", out,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    assert done.stderr == ""
    return done, load_run(out)


@pytest.fixture(scope="module")
def naughty(lpcompare, cloud_file, tmp_path_factory):
    out = tmp_path_factory.mktemp("naughty") / "run"
    return run_methods(lpcompare, cloud_file, out, [*NAUGHTY, "well_behaved"])


@pytest.mark.parametrize("method", NAUGHTY)
def test_each_misdeed_has_its_status_and_its_sentence(naughty, method):
    status, message = NAUGHTY[method]
    (record,) = [r for r in naughty[1].records if r.method == method]
    assert record.status == status
    assert record.message.startswith(message)


def test_the_run_is_complete_and_its_table_shows_every_method(naughty):
    done, run = naughty
    assert run.complete
    assert all(name in done.stdout for name in [*NAUGHTY, "well_behaved"])
    assert "noise" not in done.stdout
    assert max(map(len, done.stdout.splitlines()[:-1])) <= 100


def test_a_good_method_gives_the_same_points_as_without_them(naughty, lpcompare, cloud_file, tmp_path):
    _, alone = run_methods(lpcompare, cloud_file, tmp_path / "run", ["well_behaved"])
    (other,) = [r for r in naughty[1].records if r.method == "well_behaved"]
    (record,) = alone.records
    assert record.points_sha256 == other.points_sha256
    assert record.metrics == other.metrics
    points = [np.load(run.folder / r.cloud)["points"] for run, r in ((alone, record), (naughty[1], other))]
    assert np.array_equal(*points)


def test_what_a_method_started_dies_with_it(program, cloud_file, tmp_path, plugin_environment):
    plugin_environment["CHILD_PID_FILE"] = str(tmp_path / "pid")
    run_methods(program, cloud_file, tmp_path / "run", ["leaves_a_child"])
    assert not psutil.pid_exists(int((tmp_path / "pid").read_text()))
    assert left(tmp_path) == []


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGKILL], ids=lambda s: s.name)
def test_after_the_end_of_lpcompare_nothing_is_left_and_the_next_start_tidies_up(
    lpcompare, cloud_file, tmp_path, plugin_environment, number
):
    environment = plugin_environment | {"CHILD_PID_FILE": str(tmp_path / "pid")}
    words = ["run", "--model", str(cloud_file), "--method", "leaves_a_child", "--out", str(tmp_path / "run")]
    process = subprocess.Popen(
        [sys.executable, "-m", "lpcompare.cli", *words],
        env=environment,
        stderr=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),  # noqa: PLW1509 - perhaps under nohup
    )
    deadline = time.monotonic() + 60
    while not (tmp_path / "pid").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.2)
    assert left(tmp_path), "they run"
    process.send_signal(number)
    process.wait(timeout=60)
    deadline = time.monotonic() + 5
    while left(tmp_path) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert left(tmp_path) == []
    assert list((tmp_path / "run" / ".work").iterdir())
    again = ["--method", "well_behaved", "--reduction", 0.8, "--resume", "--out", tmp_path / "run"]
    assert lpcompare("run", "--model", cloud_file, *again).returncode == 0
    assert not (tmp_path / "run" / ".work").exists()


def left(folder):
    """Processes whose current folder lies in this one."""
    found = []
    for process in psutil.process_iter(["cwd", "status"]):
        inside = (process.info["cwd"] or "").startswith(str(folder))
        if inside and process.info["status"] != psutil.STATUS_ZOMBIE:
            found.append(process.pid)
    return found
