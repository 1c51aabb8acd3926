"""``lpcompare simplify`` in tiles: what it takes, what it says, and that nothing of it is left running."""

import functools
import http.server
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest
from typer.testing import CliRunner

import lpcompare
from lpcompare.cli import build_app
from lpcompare.cli._large import parse_size
from lpcompare.errors import InputError
from lpcompare.io import read


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    points = np.random.default_rng(0).random((5000, 3)) * [10, 10, 0.1]
    path = tmp_path_factory.mktemp("scan") / "scan.npy"
    np.save(path, points)
    return path


def simplify(*words):
    return CliRunner().invoke(build_app(), ["simplify", *map(str, words)])


def test_tiles_are_taken_where_they_are_asked_for(scan, tmp_path):
    out = tmp_path / "thin.npy"
    result = simplify(scan, out, "--reduction", 0.9, "--tiles", 3, "--method", "lp_density")
    assert result.exit_code == 0
    assert "scan.npy: 5,000 -> 500 points by lp_density in 3 tiles" in result.output
    assert len(read(out)) == 500


def test_tiles_are_taken_by_themselves_where_memory_is_short(scan, tmp_path):
    out = tmp_path / "thin.npy"
    result = simplify(scan, out, "--count", 500, "--method", "random_sample", "--memory", "300.7MiB")
    assert "random_sample in" in result.output
    assert "tiles" in result.output
    plenty = simplify(scan, out, "--count", 500, "--method", "random_sample", "--memory", "2GiB")
    assert "tiles" not in plenty.output


def test_a_url_is_fetched_once(scan, tmp_path):
    pytest.importorskip("fsspec")
    pytest.importorskip("aiohttp")
    requests = []

    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *words):
            requests.append(words)

    serve = functools.partial(Handler, directory=str(scan.parent))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), serve) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{server.server_port}/scan.npy"
        result = simplify(url, tmp_path / "thin.npy", "--count", 400, "--method", "random_sample")
        missing = simplify(url + "x.npy", tmp_path / "none.npy", "--count", 4, "--method", "random_sample")
        server.shutdown()
    gone = simplify(url, tmp_path / "gone.npy", "--count", 4, "--method", "random_sample")
    assert "cannot be fetched" in str(gone.exception)
    assert "room" not in str(gone.exception)
    assert result.exit_code == 0
    assert len(np.load(tmp_path / "thin.npy")) == 400
    assert sum("GET /scan.npy HTTP" in str(words) for words in requests) == 1
    assert isinstance(missing.exception, InputError)
    assert "cannot be fetched" in str(missing.exception)


def test_several_inputs_and_one_output_are_one_cloud(scan, tmp_path):
    np.save(tmp_path / "more.npy", np.load(scan)[::5] + 20)
    result = simplify(
        scan, tmp_path / "more.npy", tmp_path / "thin.npy", "--count", 60, "--method", "random_sample"
    )
    assert "2 inputs: 6,000 -> 60 points" in result.output
    assert len(np.load(tmp_path / "thin.npy")) == 60


def test_evaluate_prints_the_figures_of_the_whole_clouds(scan, tmp_path):
    np.save(tmp_path / "thin.npy", np.load(scan)[::10])
    result = CliRunner().invoke(
        build_app(), ["evaluate", str(scan), str(tmp_path / "thin.npy"), "--tiles", "4"]
    )
    values = dict(line.split() for line in result.output.splitlines())
    known = lpcompare.evaluate(np.load(scan), np.load(tmp_path / "thin.npy"))
    assert values["plane_error_pct"] == f"{known['plane_error_pct']:.6g}"
    assert values["hausdorff_pct"] == f"{known['hausdorff_pct']:.6g}"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--max-error", 1], "need the whole cloud"),
        (["--count", 9, "--refine"], "--refine needs the whole cloud"),
        (["--count", 9, "--memory", "much"], "give a size such as 4GiB"),
        (["--count", 9, "--method", "farthest_point"], "does not work in tiles"),
    ],
)
def test_what_tiles_cannot_do_is_said(scan, tmp_path, words, said):
    result = simplify(scan, tmp_path / "thin.npy", "--tiles", 2, *words)
    assert isinstance(result.exception, InputError)
    assert said in str(result.exception)


def test_sizes():
    assert [parse_size(t) for t in ("4GiB", "512 MiB", "2G", "1.5k", "7")] == [2**32, 2**29, 2**31, 1536, 7]


@pytest.mark.parametrize("options", [[], ["--workers", "1"]])
def test_ctrl_c_leaves_nothing_running_and_names_the_folder(scan, tmp_path, options):
    if options:
        pytest.importorskip("distributed")
    command = [
        sys.executable,
        "-m",
        "lpcompare.cli",
        "simplify",
        scan,
        tmp_path / "thin.npy",
        "--count",
        "900",
    ]
    process = subprocess.Popen(
        [*map(str, command), "--tiles", "40", *options],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    spill = tmp_path / ".thin.npy.spill"
    until = time.monotonic() + 120
    while not (spill / "measured").exists() and process.poll() is None and time.monotonic() < until:
        time.sleep(0.05)
    children = psutil.Process(process.pid).children(recursive=True)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, said = process.communicate(timeout=60)
    _, left = psutil.wait_procs(children, timeout=20)
    assert not left
    assert process.returncode == 130
    assert f"{spill}; continue with --resume" in said
    assert "Traceback" not in said
    assert (spill / "job.json").exists()
    assert not (tmp_path / "thin.npy").exists()
    assert bool(children) == bool(options)


def test_evaluate_says_what_it_leaves_out(lpcompare, scan, tmp_path):
    points = np.load(scan)[::9].copy()
    points[:2] = np.nan
    np.save(tmp_path / "thin.npy", points)
    done = lpcompare("evaluate", scan, tmp_path / "thin.npy")
    assert done.returncode == 0, done.stderr
    assert done.stderr == (
        "lpcompare: The reduced cloud: 2 of 556 points have no finite coordinates and are left out.\n"
    )
    assert "plane_error_pct" in done.stdout


@pytest.mark.skipif(os.name == "nt", reason="a shell of POSIX closes the streams")
@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_end_nothing(scan, tmp_path, closed):
    command = f"exec {sys.executable} -m lpcompare.cli evaluate {scan} {scan} {closed}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert ("plane_error_pct" in done.stdout) == (closed in ("<&-", "2>&-"))
