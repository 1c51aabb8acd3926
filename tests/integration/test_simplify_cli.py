"""``lpcompare simplify`` from files to files, and what it says when it cannot."""

import io
import os
import re
import subprocess
import sys
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

import laspy
import numpy as np
import pytest
from plyfile import PlyData

from lpcompare import cli
from lpcompare.io import read, write
from lpcompare.types import PointCloud

NOBODY = 65534
QUICK = ("--method", "random_sample", "--reduction", "0.9")


@pytest.fixture
def cloud():
    rng = np.random.default_rng(4)
    return PointCloud(
        rng.normal(size=(400, 3)),
        colors=rng.integers(0, 256, (400, 4)) / 255,
        attributes={"label": rng.integers(0, 9, 400).astype(np.uint8)},
        name="scan",
    )


@pytest.fixture
def lpcompare(monkeypatch, capsysbinary):
    """Run the command; returns exit code, standard output (bytes) and standard error (text)."""

    def call(*words):
        monkeypatch.setattr(sys, "argv", ["lpcompare", "simplify", *map(str, words)])
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = end.code or 0
        out = capsysbinary.readouterr()
        return code, out.out, out.err.decode()

    return call


def test_the_default_method_keeps_the_count_and_every_attribute(lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.ply", cloud)
    code, out, err = lpcompare(tmp_path / "scan.ply", tmp_path / "thin.ply", "--reduction", "0.9")
    assert (code, err) == (0, "")
    pattern = (
        rb"scan\.ply: 400 -> 40 points by lp_uniform, plane error \(eq\. 27\) \d+\.\d{4} % of the diagonal "
        rb"\(.+ model units\), \d+\.\d\d s in the call, \d+\.\d\d s in all"
    )
    assert re.match(pattern, out)
    thin = read(tmp_path / "thin.ply")
    rows = {tuple(p): i for i, p in enumerate(cloud.points)}
    kept = [rows[tuple(p)] for p in thin.points]
    assert kept == sorted(kept)
    assert np.array_equal(thin.attributes["label"], cloud.attributes["label"][kept])
    assert np.array_equal(thin.colors, cloud.colors[kept])


def test_the_same_seed_writes_the_same_file(lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.ply", cloud)
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        lpcompare(tmp_path / "scan.ply", tmp_path / f"{name}.ply", *QUICK, "--seed", seed)
    a, b, c = ((tmp_path / f"{name}.ply").read_bytes() for name in "abc")
    assert a == b
    assert a != c


def test_a_count_may_stand_for_the_reduction(lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.laz", cloud)
    code, *_ = lpcompare(
        tmp_path / "scan.laz", tmp_path / "t.laz", "--count", 133, "--method", "random_sample"
    )
    assert code == 0
    assert laspy.read(tmp_path / "t.laz").header.point_count == 133


def test_a_folder_as_input_is_told_how_to_name_its_files(lpcompare, tmp_path):
    code, _, err = lpcompare(tmp_path, tmp_path / "out", "--count", "5")
    assert code == 2
    assert f"{tmp_path} is a folder; name its files" in err
    assert not (tmp_path / "out").exists()


def test_several_inputs_and_patterns_go_to_a_folder_and_one_bad_file_stops_no_other(
    lpcompare, cloud, tmp_path
):
    for name in ("a.ply", "b.ply"):
        write(tmp_path / name, cloud)
    (tmp_path / "broken.ply").write_bytes((tmp_path / "a.ply").read_bytes()[:-9])
    code, out, err = lpcompare(tmp_path / "*.ply", tmp_path / "out", *QUICK)
    assert code == 2
    assert out.count(b"-> 40 points") == 2
    assert err.count("\n") == 1
    assert "broken.ply" in err
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["a.ply", "b.ply"]


def test_standard_output_is_a_ply_and_the_report_goes_to_standard_error(lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.npz", cloud)
    code, out, err = lpcompare(tmp_path / "scan.npz", "-", *QUICK)
    assert code == 0
    assert len(PlyData.read(io.BytesIO(out))["vertex"].data) == 40
    assert "400 -> 40 points" in err


def test_another_format_says_what_it_cannot_hold(lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.ply", cloud)
    code, out, _ = lpcompare(tmp_path / "scan.ply", tmp_path / "t.off", *QUICK)
    assert code == 0
    assert b".off holds no attributes" in out


@pytest.mark.parametrize("suffix", [".ply", ".off"])
def test_faces_of_a_mesh_are_left_out_and_said_so(suffix, lpcompare, cloud, tmp_path):
    mesh = PointCloud(cloud.points, faces=np.array([[0, 1, 2], [2, 3, 4]]))
    write(tmp_path / "mesh.ply", mesh)
    code, out, _ = lpcompare(tmp_path / "mesh.ply", tmp_path / f"t{suffix}", *QUICK)
    assert code == 0
    assert out.count(b"faces are left out") == 1
    assert read(tmp_path / f"t{suffix}").faces is None


def test_moved_points_are_written_without_attributes_and_said_so(lpcompare, tmp_path):
    ball = np.random.default_rng(0).normal(size=(300, 3))
    write(tmp_path / "scan.ply", PointCloud(ball, attributes={"label": np.arange(300)}))
    code, out, _ = lpcompare(
        tmp_path / "scan.ply", tmp_path / "t.ply", "--method", "clustering_decimation", "--count", 30
    )
    assert code == 0
    assert b"only coordinates" in out
    assert read(tmp_path / "t.ply").attributes == {}


def test_an_input_is_replaced_only_when_told(lpcompare, cloud, tmp_path):
    path = tmp_path / "scan.ply"
    write(path, cloud)
    before = path.read_bytes()
    code, _, err = lpcompare(path, path, *QUICK)
    assert code == 2
    assert "--force" in err
    assert path.read_bytes() == before
    (tmp_path / "link.ply").symlink_to(path)
    assert lpcompare(path, tmp_path / "link.ply", *QUICK)[0] == 2
    assert lpcompare(path, path, *QUICK, "--force")[0] == 0
    assert len(read(path)) == 40


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ((), "either --reduction"),
        (("--reduction", "0.5", "--count", "9"), "either --reduction"),
        (("--reduction", "1.5"), "target_reduction is 1.5"),
        (("--reduction", "nan"), "target_reduction is nan"),
        (("--count", "0"), "1 to 400"),
        (("--count", "401"), "1 to 400"),
        (("--reduction", "0.5", "--method", "lp_densty"), "Did you mean 'lp_density'"),
        (("--reduction", "0.5", "--set", "n_cluster=3"), "Did you mean 'n_clusters'"),
        (("--reduction", "0.5", "--set", "n_clusters=many"), "a str"),
        (("--reduction", "0.5", "--seed", "-1"), "seed is -1"),
        ((*QUICK, "--set", "size=1"), "'size'. There is none"),
        ((*QUICK, "--tiles", "0"), "--tiles is 0"),
        ((*QUICK, "--workers", "-1"), "--workers is -1"),
        ((*QUICK, "--memory", "much"), "--memory is 'much'"),
        ((*QUICK, "--memory", "0"), "--memory is '0'"),
        ((*QUICK, "--memory-limit", "0"), "--memory-limit is 0"),
        ((*QUICK, "--time-limit", "0"), "--time-limit is 0"),
    ],
)
def test_wrong_orders_are_one_sentence(words, reason, lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.ply", cloud)
    code, out, err = lpcompare(tmp_path / "scan.ply", tmp_path / "t.ply", *words)
    assert (code, out) == (2, b"")
    assert err.startswith("lpcompare: ")
    assert err.count("\n") == 1
    assert reason in err
    assert not (tmp_path / "t.ply").exists()


def spoilt(kind, suffix, cloud, folder):
    """A file that cannot be worked on."""
    path = folder / f"scan{suffix}"
    points = cloud.points.copy()
    if kind == "nan":
        points[3, 0] = np.nan
    write(path, PointCloud(points, colors=cloud.colors))
    if kind == "empty":
        path.write_bytes(b"")
    elif kind == "truncated":
        path.write_bytes(path.read_bytes()[: -path.stat().st_size // 3])
    elif kind == "mislabelled":
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))
    return path


ODD_NAMES = [b"\x1b[2Jscan.ply", b"two\nlines.ply", b"br\xfccke.ply", "\u202eylp.ply".encode()]


@pytest.mark.parametrize("name", ODD_NAMES)
def test_names_of_files_are_no_commands_to_the_terminal(name, lpcompare, cloud, tmp_path):
    scan = tmp_path / os.fsdecode(name)
    write(scan, cloud)
    code, out, _ = lpcompare(scan, tmp_path / "thin.ply", *QUICK)
    assert (code, out.count(b"\n")) == (0, 1)
    scan.write_bytes(b"ply\n")
    code, _, err = lpcompare(scan, tmp_path / "thin.ply", *QUICK)
    assert code == 2
    assert (out.decode() + err).replace("\n", "").isprintable()


def test_a_terminal_that_cannot_spell_a_name_still_gets_the_report(cloud, tmp_path):
    write(tmp_path / "橋.ply", cloud)
    command = [
        sys.executable,
        "-m",
        "lpcompare.cli",
        "simplify",
        tmp_path / "橋.ply",
        tmp_path / "b.ply",
        *QUICK,
    ]
    western = os.environ | {"PYTHONIOENCODING": "latin-1"}
    done = subprocess.run(command, env=western, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.startswith(b"\\u6a4b.ply: 400 -> 40 points")


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".xyz", ".npy", ".npz", ".pcd", ".laz"])
@pytest.mark.parametrize("kind", ["empty", "truncated", "mislabelled", "nan"])
def test_bad_files_are_one_sentence_and_no_output(kind, suffix, lpcompare, cloud, tmp_path):
    if kind == "nan" and suffix == ".laz":
        pytest.skip("LAS stores integers and holds no NaN")
    if kind == "truncated" and suffix in (".xyz", ".obj"):
        pytest.skip("rows without a count: a shorter file is a smaller cloud")
    path = spoilt(kind, suffix, cloud, tmp_path)
    code, out, err = lpcompare(path, tmp_path / f"out{suffix}", *QUICK, "--strict")
    assert (code, out) == (2, b"")
    assert err.startswith("lpcompare: ")
    assert err.count("\n") == 1
    assert path.name in err
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_points_that_lie_alone_are_left_out_on_request(lpcompare, cloud, tmp_path):
    lonely = np.add(cloud.points.max(axis=0), [[50.0, 0, 0], [0, 60, 0]])
    far = np.concatenate([cloud.points, lonely])
    write(tmp_path / "in.ply", PointCloud(far))
    code, out, err = lpcompare(tmp_path / "in.ply", tmp_path / "out.ply", *QUICK, "--drop-outliers", 5)
    assert (code, err) == (0, "")
    assert b"2 points that lie alone were left out" in out
    assert read(tmp_path / "out.ply").points.max() <= cloud.points.max()
    code, out, err = lpcompare(
        tmp_path / "in.ply", tmp_path / "o.ply", *QUICK, "--drop-outliers", 5, "--tiles", 2
    )
    assert (code, out) == (2, b"")
    assert "--drop-outliers needs the whole cloud in memory" in err


def test_points_without_coordinates_are_left_out_and_counted(lpcompare, cloud, tmp_path):
    path = spoilt("nan", ".ply", cloud, tmp_path)
    code, out, err = lpcompare(path, tmp_path / "out.ply", *QUICK)
    assert (code, err) == (0, "")
    assert b"1 points without coordinates were left out" in out
    assert np.isfinite(read(tmp_path / "out.ply").points).all()


def test_every_metric_and_an_order_on_demand(lpcompare, cloud, tmp_path):
    path = tmp_path / "scan.ply"
    write(path, cloud)
    code, out, _ = lpcompare(
        path, tmp_path / "t.ply", "--count", 40, "--method", "farthest_point", "--order", "--evaluate"
    )
    assert code == 0
    assert b"hausdorff_pct" in out
    assert sorted(read(tmp_path / "t.ply").attributes["order"].tolist()) == list(range(40))


def test_a_tolerance_chooses_the_count(lpcompare, cloud, tmp_path):
    path = tmp_path / "scan.ply"
    write(path, cloud)
    words = ("--tolerance", "0.5", "--method", "farthest_point")
    assert lpcompare(path, tmp_path / "t.ply", *words)[0] == 0
    assert 1 <= len(read(tmp_path / "t.ply")) < 400


@contextmanager
def without_privileges():
    """As nobody, where the tests run as the superuser, who may read and write everything.

    Run the command to an error before, so that it has nothing left to import.
    """
    if os.geteuid() != 0:
        yield
        return
    os.setresuid(NOBODY, NOBODY, 0)
    try:
        if not os.access(cli.__file__, os.R_OK):
            pytest.skip("the superuser's installation is closed to the user without rights")
        yield
    finally:
        os.setresuid(0, 0, 0)


@pytest.fixture
def open_folder():
    """A folder that everybody may enter and change, unlike pytest's own."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o777)
        yield Path(folder)


def refused_as_nobody(lpcompare, source, target):
    with without_privileges():
        code, out, err = lpcompare(source, target, *QUICK)
    assert (code, out, err.count("\n")) == (2, b"", 1)
    return err


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".xyz", ".npy", ".npz", ".pcd", ".laz", ".las"])
def test_a_file_that_may_not_be_read(suffix, lpcompare, cloud, open_folder):
    path, target = open_folder / f"scan{suffix}", open_folder / f"out{suffix}"
    write(path, cloud)
    assert "1 to 400" in lpcompare(path, target, "--count", 0)[2]
    path.chmod(0)
    err = refused_as_nobody(lpcompare, path, target)
    assert err == f"lpcompare: {path} cannot be read: Permission denied.\n"
    assert list(open_folder.iterdir()) == [path]


def test_folders_that_may_not_be_entered_or_written_to(lpcompare, cloud, open_folder):
    source, closed = open_folder / "scan.ply", open_folder / "closed"
    closed.mkdir()
    write(source, cloud)
    write(closed / "scan.ply", cloud)
    assert "1 to 400" in lpcompare(source, closed / "t.ply", "--count", 0)[2]
    closed.chmod(0o555)
    err = refused_as_nobody(lpcompare, source, closed / "t.ply")
    assert err == f"lpcompare: The folder {closed} cannot be written to; name another.\n"
    closed.chmod(0)
    err = refused_as_nobody(lpcompare, closed / "scan.ply", open_folder / "t.ply")
    assert err.startswith(f"lpcompare: {closed / 'scan.ply'}")
    assert err.endswith(": Permission denied.\n")
    closed.chmod(0o755)
    assert {path.name for path in open_folder.rglob("*")} == {"closed", "scan.ply"}


def test_a_folder_that_is_not_there_is_refused_before_any_work(lpcompare, cloud, tmp_path):
    write(tmp_path / "scan.ply", cloud)
    assert "does not exist" in lpcompare(tmp_path / "scan.ply", tmp_path / "no" / "t.ply", *QUICK)[2]
    assert "cannot be written" in lpcompare(tmp_path / "scan.ply", tmp_path / "t.stl", *QUICK)[2]


def test_one_point_stays_one_point(lpcompare, tmp_path):
    write(tmp_path / "one.ply", PointCloud(np.array([[5e5, 4e6, 100.0]])))
    assert lpcompare(tmp_path / "one.ply", tmp_path / "t.ply", "--reduction", "0.9")[0] == 0
    assert read(tmp_path / "t.ply").points.tolist() == [[5e5, 4e6, 100.0]]


def test_an_interrupted_reader_of_the_output_is_no_traceback(cloud, tmp_path):
    write(tmp_path / "scan.ply", cloud)
    program = "from lpcompare.cli import main; main()"
    command = [sys.executable, "-c", program, "simplify", str(tmp_path / "scan.ply"), "-", *QUICK]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    child.stdout.close()
    err = child.stderr.read().decode()
    child.wait()
    child.stderr.close()
    assert "Traceback" not in err


@pytest.mark.skipif(sys.platform == "win32", reason="it needs a pseudo-terminal")
def test_on_a_terminal_the_report_stands_alone_in_lines_that_fit(cloud, tmp_path):
    import pty

    write(tmp_path / "scan.ply", cloud)
    parent, child = pty.openpty()
    words = ["simplify", tmp_path / "scan.ply", tmp_path / "thin.ply", *QUICK]
    command = [sys.executable, "-m", "lpcompare.cli", *map(str, words)]
    environment = os.environ | {"COLUMNS": "80", "TERM": "xterm"}
    with subprocess.Popen(command, stdout=child, stderr=child, env=environment) as process:
        os.close(child)
        written = b""
        with suppress(OSError):  # Linux says so when the other side is closed
            while part := os.read(parent, 65536):
                written += part
    os.close(parent)
    assert process.returncode == 0
    end_of_bar = rb"\x1b[\x5b]\?25h\s*\x1b[\x5b]1A\x1b[\x5b]2K"
    report = re.split(end_of_bar, written)[-1].decode().splitlines()
    assert report[0].startswith("scan.ply: 400 -> 40 points by random_sample")
    assert len(report) > 1
    assert max(map(len, report)) <= 80
