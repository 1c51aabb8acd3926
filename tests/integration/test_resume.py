"""A run that is killed, stopped or out of disk is readable, and --resume completes it without repeating."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from lpcompare.harness.record import load_run

STUDY = """
reductions = [0.8]
repeats = 2
methods = ["random_sample", "sleeps"]
[settings.sleeps]
seconds = 0.2
[perturbations]
noise = [0.2]
"""
N_CASES = 2 * 2 * 2


@pytest.fixture(scope="module")
def words(tmp_path_factory, cloud_file):
    path = tmp_path_factory.mktemp("study") / "study.toml"
    path.write_text(STUDY)
    return ["run", "--study", str(path), "--model", str(cloud_file)]


@pytest.fixture(scope="module")
def uninterrupted(lpcompare, words, tmp_path_factory):
    """A run with one thread that nothing disturbed."""
    out = tmp_path_factory.mktemp("uninterrupted") / "run"
    assert lpcompare(*words, "--threads", 1, "--out", out).returncode == 0
    return load_run(out)


@pytest.fixture
def start(plugin_environment):
    """Start the command line and wait until it has finished some records."""

    def start(words, out, n_records):
        process = subprocess.Popen(
            [sys.executable, "-m", "lpcompare.cli", *words, "--out", str(out)],
            env=plugin_environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and _n_lines(out) < n_records:
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.02)
        return process

    return start


def _n_lines(out):
    path = out / "records.jsonl"
    return len(path.read_text().splitlines()) if path.exists() else 0


def _identity(record):
    return (record.variant, record.perturbation, record.reduction, record.seed, record.repeat)


def _results(run):
    return {_identity(r): (r.status, r.n_output, r.points_sha256, r.metrics) for r in run.records}


def test_kill_9_and_resume_equal_an_uninterrupted_run_to_the_bit(
    lpcompare, words, start, uninterrupted, tmp_path
):
    out = tmp_path / "killed"
    process = start(words, out, n_records=3)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    half = load_run(out)
    assert not half.complete
    assert 3 <= len(half.records) < N_CASES
    assert lpcompare(*words, "--out", out).returncode == 2, "a run is not overwritten"

    assert lpcompare(*words, "--out", out, "--resume").returncode == 0
    whole, other = load_run(out), uninterrupted

    assert whole.complete
    assert len(whole.records) == len(_results(whole)) == N_CASES
    assert _results(whole) == _results(other)
    seconds = {_identity(r): r.runtime_s for r in whole.records}
    assert all(seconds[_identity(r)] == r.runtime_s for r in half.records), "finished cases are kept"
    for mine, theirs in zip(whole.records, other.records, strict=True):
        assert mine.cloud == theirs.cloud
        if mine.cloud:
            a, b = np.load(whole.folder / mine.cloud), np.load(other.folder / theirs.cloud)
            assert all(np.array_equal(a[name], b[name]) for name in a)


def test_a_finished_run_is_resumed_without_running_anything(lpcompare, words, uninterrupted):
    folder, before = uninterrupted.folder, uninterrupted.records
    assert lpcompare(*words, "--threads", 1, "--out", folder, "--resume").returncode == 0
    assert load_run(folder).records == before


def test_only_what_a_limit_may_have_ended_is_run_again_under_another_limit(lpcompare, cloud_file, tmp_path):
    out = tmp_path / "run"
    words = ["run", "--model", cloud_file, "--method", "random_sample", "--method", "raises"]
    words += ["--reduction", 0.8, "--out", out]

    def resume(*more):
        assert lpcompare(*words, *more).returncode == 0
        return [r.message for r in load_run(out).records]

    good, bad = resume()
    document = json.loads((out / "run.json").read_text())
    document["records"] = [row | {"message": "earlier"} for row in document["records"]]
    (out / "run.json").write_text(json.dumps(document))

    assert good == "" != bad
    assert resume("--resume") == ["earlier", "earlier"]
    assert resume("--resume", "--time-limit", 200) == ["earlier", bad]


def test_ctrl_c_leaves_a_readable_run_and_exit_code_130(words, start, tmp_path):
    process = start(words, tmp_path / "run", n_records=2)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "--resume" in stderr
    assert "Traceback" not in stderr
    run = load_run(tmp_path / "run")
    assert not run.complete
    assert 2 <= len(run.records) < N_CASES
    assert all(record.status == "ok" for record in run.records)
    assert (tmp_path / "run" / "records.csv").exists()


def test_ctrl_c_ends_several_jobs_at_once(words, start, tmp_path):
    process = start([*words, "--jobs", "2"], tmp_path / "run", n_records=2)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=20)
    assert process.returncode == 130
    assert all(record.status == "ok" for record in load_run(tmp_path / "run").records)


def test_several_jobs_give_the_same_points_and_say_that_runtimes_are_unreliable(
    lpcompare, words, uninterrupted, tmp_path
):
    done = lpcompare(*words, "--out", tmp_path / "two", "--jobs", 2)
    assert "do not compare the runtimes" in " ".join(done.stdout.split())
    two, one = load_run(tmp_path / "two"), uninterrupted
    assert _results(one) == _results(two)
    assert [_identity(r) for r in one.records] == [_identity(r) for r in two.records]


@pytest.mark.parametrize(
    ("more", "reason", "n_records"),
    [(["--repeats", "30"], "File too large", 3), (["--reduction", "0.1"], "is the disk full?", 0)],
    ids=["while a record is written", "while a child writes its result"],
)
def test_a_full_disk_ends_in_a_sentence_and_a_readable_run(
    plugin_environment, words, tmp_path, more, reason, n_records
):
    """A limit on the size of a file stands in for the full disk; both fail in write()."""
    limited = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (14_000, resource.RLIM_INFINITY));"
        "from lpcompare.cli import main; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", limited, *words, "--out", str(tmp_path / "run"), *more],
        env=plugin_environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert reason in done.stderr
    assert "--resume" in done.stderr
    run = load_run(tmp_path / "run")
    assert not run.complete
    assert len(run.records) >= n_records
    assert all(record.status == "ok" for record in run.records), "no method is blamed"


def test_a_line_cut_short_is_left_out(uninterrupted, tmp_path):
    document = json.loads((uninterrupted.folder / "run.json").read_text())
    lines = [json.dumps(row) + "\n" for row in document["records"]]
    (tmp_path / "run.json").write_text(json.dumps(document | {"records": [], "complete": False}))
    (tmp_path / "records.jsonl").write_text("".join(lines)[:-30])
    assert len(load_run(tmp_path).records) == N_CASES - 1
