"""A run that is killed, stopped or out of disk is readable, and --resume completes it without repeating.

No second process may write into its folder meanwhile, and no finished case is ever lost.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from lpcompare.benchmark.record import load_run

STUDY = """
reductions = [0.8]
repeats = 2
methods = ["random_sample", "sleeps"]
[settings.sleeps]
seconds = 0.3
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


def test_a_finished_run_is_resumed_without_running_anything(lpcompare, words, uninterrupted):
    folder, before = uninterrupted.folder, uninterrupted.records
    assert lpcompare(*words, "--threads", 1, "--out", folder, "--resume").returncode == 0
    assert load_run(folder).records == before


def test_only_what_a_limit_may_have_ended_is_run_again_under_another_limit(lpcompare, cloud_file, tmp_path):
    out = tmp_path / "run"
    words = ["run", "--model", cloud_file, "--method", "random_sample", "--method", "raises"]
    words += ["--reduction", 0.8, "--out", out]

    def resume(*more):
        assert lpcompare(*words, *more).returncode == 1
        return [r.message for r in load_run(out).records]

    good, bad = resume()
    document = json.loads((out / "run.json").read_text())
    document["records"] = [row | {"message": "earlier"} for row in document["records"]]
    (out / "run.json").write_text(json.dumps(document))

    assert good == "" != bad
    assert resume("--resume") == ["earlier", "earlier"]
    assert resume("--resume", "--time-limit", 200) == ["earlier", bad]


def test_ctrl_c_leaves_a_readable_run_that_is_not_overwritten_and_exit_code_130(
    lpcompare, words, start, tmp_path
):
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
    assert lpcompare(*words, "--out", tmp_path / "run").returncode == 2
    assert load_run(tmp_path / "run").records == run.records


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


@pytest.fixture
def on_a_full_disk(lpcompare, plugin_environment, monkeypatch):
    """Run the command line where no file grows beyond a size: like a full disk, it fails in write()."""

    def run(size, *words):
        monkeypatch.setitem(plugin_environment, "LARGEST_FILE", str(size))
        done = lpcompare(*words)
        monkeypatch.delitem(plugin_environment, "LARGEST_FILE")
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        return done.stderr

    return run


@pytest.mark.parametrize(
    ("more", "reason", "n_records"),
    [(["--repeats", "30"], "File too large", 3), (["--reduction", "0.1"], "File too large", 0)],
    ids=["while a record is written", "while a child writes its result"],
)
def test_a_full_disk_ends_in_a_sentence_and_a_readable_run(
    on_a_full_disk, words, tmp_path, more, reason, n_records
):
    told = on_a_full_disk(14_000, *words, "--out", tmp_path / "run", *more)
    assert reason in told
    assert "--resume" in told
    run = load_run(tmp_path / "run")
    assert not run.complete
    assert len(run.records) >= n_records
    assert all(record.status == "ok" for record in run.records), "no method is blamed"


@pytest.mark.parametrize(("size", "file"), [(1_000, "ball.npz"), (12_900, "run.json")])
def test_a_full_disk_before_the_first_case_is_one_sentence(on_a_full_disk, words, tmp_path, size, file):
    seeds = [word for seed in range(300) for word in ("--seed", seed)]
    more = [] if file == "ball.npz" else ["--reduction", 0.9, *seeds]
    out = tmp_path / "run"
    told = on_a_full_disk(size, *words, *more, "--out", out)
    assert told.count("\n") == 1
    assert f"{file} cannot be written (File too large); make room and continue with --resume." in told
    assert not list(out.rglob("*.part"))


def test_a_full_disk_for_the_page_leaves_the_run_and_no_half_page(on_a_full_disk, cloud_file, tmp_path):
    out = tmp_path / "run"
    words = ["--model", cloud_file, "--method", "random_sample", "--reduction", 0.8]
    told = on_a_full_disk(100_000, "run", *words, "--out", out)
    assert told.count("\n") == 1
    assert "report.html cannot be written (File too large); make room, or name another file: " in told
    assert f"lpcompare report {out} --out" in told
    assert load_run(out).complete
    assert not list(out.glob("report.html*"))


def test_a_second_writer_is_turned_away_and_changes_nothing(lpcompare, words, start, tmp_path):
    out = tmp_path / "run"
    first = start([*words, "--repeats", "4"], out, n_records=1)
    for more in ([], ["--resume"]):
        document = (out / "run.json").read_bytes()
        second = lpcompare(*words, "--repeats", 4, "--out", out, *more)
        assert first.poll() is None, "the first was over before the second began"
        assert second.returncode == 2
        assert second.stderr.count("\n") == 1
        assert "is being written by another lpcompare; wait until it has ended" in second.stderr
        assert (out / "run.json").read_bytes() == document
    assert first.wait(timeout=120) == 0
    first.communicate()
    run = load_run(out)
    assert run.complete
    assert len(run.records) == 2 * N_CASES
    assert all(record.status == "ok" for record in run.records)
    assert lpcompare(*words, "--repeats", 4, "--out", out, "--resume").returncode == 0, "the lock is free"


def test_what_the_new_plan_does_not_name_stays_in_the_run(lpcompare, cloud_file, tmp_path):
    out = tmp_path / "run"
    words = ["run", "--model", cloud_file, "--threads", 1, "--out", out]

    def resume(*more):
        assert lpcompare(*words, *more).returncode == 1
        run = load_run(out)
        assert run.complete
        return {(r.method, r.reduction): r for r in run.records}

    first = resume("--method", "random_sample", "--method", "raises", "--reduction", 0.8)
    second = resume(
        *("--method", "stratified_sample", "--method", "random_sample", "--reduction", 0.9),
        *("--resume", "--time-limit", 200),
    )
    assert list(second) == [("stratified_sample", 0.9), ("random_sample", 0.9), *first]
    assert first.items() <= second.items()
    assert all((out / record.cloud).exists() for record in second.values() if record.cloud)
    assert resume("--method", "random_sample", "--reduction", 0.8, "--resume").items() == second.items()


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        (["--threads", 2], "with threads 1, and now 2 is asked for"),
        (["--threads", 1, "--metric", "all"], "with metrics "),
        (["--threads", 1, "--refine"], "with refine False, and now True"),
    ],
)
def test_other_conditions_are_refused_and_nothing_is_lost(lpcompare, words, uninterrupted, more, reason):
    before = (uninterrupted.folder / "run.json").read_bytes()
    done = lpcompare(*words, *more, "--out", uninterrupted.folder, "--resume")
    assert done.returncode == 2
    assert reason in done.stderr
    assert "name another folder with --out" in done.stderr
    assert (uninterrupted.folder / "run.json").read_bytes() == before


def test_another_cloud_of_the_same_name_is_refused(lpcompare, words, uninterrupted, tmp_path):
    np.save(tmp_path / "ball.npy", np.eye(3))
    words = [*words[:-1], tmp_path / "ball.npy"]
    done = lpcompare(*words, "--threads", 1, "--out", uninterrupted.folder, "--resume")
    assert done.returncode == 2
    assert "another cloud called 'ball'" in done.stderr
    assert load_run(uninterrupted.folder).records == uninterrupted.records


def _cut(lines, rng):
    lines[-1] = lines[-1][: rng.integers(1, len(lines[-1]))]


def _garbage(lines, rng):
    lines.append(rng.bytes(200))


def _nuls(lines, rng):
    lines.append(bytes(4096))


def _blank_lines(lines, rng):
    lines[1:1] = [b"", b"  ", b"\r"]


def _flipped_byte(lines, rng):
    line = bytearray(lines[number := rng.integers(len(lines))])
    line[rng.integers(len(line))] ^= 1 << rng.integers(8)
    lines[number] = bytes(line)


def _half_a_line_within(lines, rng):
    lines.insert(0, lines[-1][:50])


def _a_line_twice(lines, rng):
    lines.append(lines[0])


def _nothing(lines, rng):
    pass


DAMAGE = (_nothing, _cut, _garbage, _nuls, _blank_lines, _flipped_byte, _half_a_line_within, _a_line_twice)


@pytest.fixture
def n_moments(request):
    return 50 if request.config.getoption("--long") else 3


def test_kill_9_at_any_moment_and_a_damaged_file_resume_to_the_bit(
    lpcompare, words, start, uninterrupted, tmp_path, n_moments
):
    rng = np.random.default_rng(14)
    for moment in range(n_moments):
        out, damage = tmp_path / f"run{moment}", DAMAGE[moment % len(DAMAGE)]
        process = start([*words, "--threads", "1"], out, n_records=1 + moment % 3)
        time.sleep(rng.uniform(0, 1.5))
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        _check_resumed(lpcompare, words, out, damage, rng, uninterrupted)


def _check_resumed(lpcompare, words, out, damage, rng, uninterrupted):
    if (file := out / "records.jsonl").exists():  # else it was killed after its end
        lines = file.read_bytes().split(b"\n")[:-1]
        damage(lines, rng)
        file.write_bytes(b"\n".join(lines) + b"\n")
    half = load_run(out)
    done = lpcompare(*words, "--threads", 1, "--out", out, "--resume")
    assert done.returncode == 0, (damage, done.stderr)
    whole = load_run(out)
    assert whole.complete
    assert len(whole.records) == N_CASES
    assert _results(whole) == _results(uninterrupted), damage
    seconds = {_identity(r): r.runtime_s for r in whole.records}
    assert all(seconds[_identity(r)] == r.runtime_s for r in half.records), "finished cases are kept"
    _check_clouds(whole, uninterrupted)


def _check_clouds(mine, theirs):
    for a, b in zip(mine.records, theirs.records, strict=True):
        if a.cloud:
            one, other = np.load(mine.folder / a.cloud), np.load(theirs.folder / b.cloud)
            assert all(np.array_equal(one[name], other[name]) for name in one)


def test_result_files_that_are_damaged_are_made_again(lpcompare, words, uninterrupted, tmp_path):
    shutil.copytree(uninterrupted.folder, tmp_path / "run")
    victims = [r for r in uninterrupted.records if r.cloud][:2]
    cut, gone = (tmp_path / "run" / victim.cloud for victim in victims)
    cut.write_bytes(cut.read_bytes()[:-9])
    gone.unlink()
    done = lpcompare(*words, "--threads", 1, "--out", tmp_path / "run", "--resume")
    assert done.returncode == 0, done.stderr
    run = load_run(tmp_path / "run")
    again = [a for a, b in zip(run.records, uninterrupted.records, strict=True) if a.runtime_s != b.runtime_s]
    assert [_identity(r) for r in again] == [_identity(victim) for victim in victims]
    _check_clouds(run, uninterrupted)


def test_a_line_cut_short_is_left_out(uninterrupted, tmp_path):
    document = json.loads((uninterrupted.folder / "run.json").read_text())
    lines = [json.dumps(row) + "\n" for row in document["records"]]
    (tmp_path / "run.json").write_text(json.dumps(document | {"records": [], "complete": False}))
    (tmp_path / "records.jsonl").write_text("".join(lines)[:-30])
    assert len(load_run(tmp_path).records) == N_CASES - 1
