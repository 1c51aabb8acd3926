"""Untrusted files and places: bombs, pipes, code beside a scan, links, modes and names of any bytes."""

import os
import shlex
import signal
import stat
import subprocess
import sys
import time
import zipfile

import numpy as np
import psutil
import pytest

from lpcompare.errors import InputError
from lpcompare.files import _remove_left_parts, replace_text, state_of, whole_file
from lpcompare.io import keep_rows, read, write
from lpcompare.types import PointCloud

CLOUD = PointCloud(np.eye(3), attributes={"id": np.arange(3)})


def zeros(path, n_bytes):
    """An archive of an array of zeros."""
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("points.npy", "w", force_zip64=True) as file,
    ):
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": (n_bytes // 24, 3)}
        )
        for _ in range(n_bytes // 2**24):
            file.write(bytes(2**24))


def header(n_properties=3, comment=0):
    names = ["x", "y", "z", *(f"p{i}" for i in range(n_properties - 3))]
    lines = ["ply", "format ascii 1.0", "comment " + "a" * comment, "element vertex 1"]
    return "\n".join([*lines, *(f"property float {name}" for name in names), "end_header\n"])


SCAN = "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n"


@pytest.mark.parametrize(
    ("name", "make", "reason"),
    [
        ("a.npz", lambda path: zeros(path, 2**26), r"its \d+ bytes would become 6710\d+"),
        ("a.ply", lambda path: path.write_text(header(30_000) + "0 " * 30_000), "more than 5000 properties"),
        (
            "a.ply",
            lambda path: path.write_text(header(comment=50_000_000)),
            "no line 'end_header' in the first",
        ),
        ("a.pcd", lambda path: path.write_text("# " + "a" * 50_000_000), "no line DATA in the first"),
        ("a.ptx", lambda path: path.write_text(SCAN * 20_000), "more than 10000 scans"),
        ("a.xyz", os.mkfifo, "no regular file but a pipe or device"),
        ("a.xyz", lambda path: path.symlink_to("/dev/zero"), "no regular file but a pipe or device"),
    ],
)
def test_bombs_are_refused_within_seconds(name, make, reason, tmp_path, monkeypatch):
    monkeypatch.setattr("lpcompare.io.arrays._LARGEST", 2**24)
    make(tmp_path / name)
    start, before = time.monotonic(), psutil.Process().memory_info().rss
    with pytest.raises(InputError, match=reason) as caught:
        read(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert time.monotonic() - start < 10
    assert psutil.Process().memory_info().rss - before < 2**29


@pytest.mark.parametrize("suffix", [".laz", ".stl"])
def test_code_beside_the_scan_or_on_the_path_is_not_run(suffix, tmp_path, monkeypatch):
    pymeshlab = pytest.importorskip("pymeshlab")
    if suffix == ".laz":
        write(tmp_path / "a.laz", CLOUD)
    else:
        layers = pymeshlab.MeshSet()
        layers.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])))
        layers.save_current_mesh(str(tmp_path / "a.stl"))
    for name in ("json", "numpy", "laspy", "pymeshlab", "sitecustomize", "usercustomize", "lpcompare"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'was-here')!r}, 'w')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert len(read(f"a{suffix}")) == 3
    assert not (tmp_path / "was-here").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such signal")
def test_the_reader_ends_with_its_parent(tmp_path):
    """A pipe in place of the rows to keep holds it for ever."""
    write(tmp_path / "a.laz", CLOUD)
    os.mkfifo(tmp_path / "rows")
    code = (
        "import sys, tempfile; from pathlib import Path; from lpcompare.io.isolated import _answer; "
        "given, answer = open(sys.argv[3], 'rb'), tempfile.TemporaryFile(); "
        "_answer(Path(sys.argv[1]), ['las', 'keep_rows', *sys.argv[1:3]], given, answer)"
    )
    held = os.open(tmp_path / "rows", os.O_RDWR)
    arguments = [tmp_path / "a.laz", tmp_path / "b.laz", tmp_path / "rows"]
    with subprocess.Popen([sys.executable, "-c", code, *arguments]) as parent:
        children = []
        while not children:
            time.sleep(0.05)
            children = psutil.Process(parent.pid).children()
        time.sleep(2)
        assert children[0].is_running()
        parent.kill()
    _, alive = psutil.wait_procs(children, timeout=5)
    os.close(held)
    assert not alive


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o400])
def test_a_file_that_is_replaced_keeps_its_mode(mode, tmp_path):
    for path, replace in {
        tmp_path / "a.ply": lambda path: write(path, CLOUD),
        tmp_path / "a.txt": lambda path: replace_text(path, "new"),
    }.items():
        path.write_text("old")
        path.chmod(mode)
        replace(path)
        assert stat.S_IMODE(path.stat().st_mode) == mode
    keep_rows(tmp_path / "a.ply", tmp_path / "a.ply", np.array([0]))
    assert stat.S_IMODE((tmp_path / "a.ply").stat().st_mode) == mode


def test_a_new_file_has_the_mode_of_the_users_mask(tmp_path):
    before = os.umask(0o027)
    try:
        write(tmp_path / "a.ply", CLOUD)
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.ply").stat().st_mode) == 0o640


def test_the_part_of_a_file_is_nobody_elses_and_goes_with_a_failure(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    (tmp_path / "a.txt").chmod(0o600)
    names = set()
    for _ in range(3):
        with pytest.raises(RuntimeError), whole_file(tmp_path / "a.txt") as part:  # noqa: PT012
            assert stat.S_IMODE(part.stat().st_mode) == 0o600
            names.add(part.name)
            raise RuntimeError
    assert len(names) == 3
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


WRITING = """
import signal, sys, time
from pathlib import Path
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # perhaps under nohup
from lpcompare.files import _remove_left_parts, replace_text, state_of, whole_file
with whole_file(Path(sys.argv[1])) as part:
    part.write_text("half")
    print(flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have other signals and locks")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL], ids=lambda s: s.name)
def test_a_signal_leaves_the_old_file_alone(number, tmp_path):
    """At once, or where nothing can be done at once, when the next one writes."""
    file, other = tmp_path / "a.txt", tmp_path / "b.txt"
    file.write_text("old")
    with subprocess.Popen([sys.executable, "-c", WRITING, other], stdout=subprocess.PIPE) as bystander:
        with subprocess.Popen([sys.executable, "-c", WRITING, file], stdout=subprocess.PIPE) as writer:
            assert bystander.stdout.readline()
            assert writer.stdout.readline()
            writer.send_signal(number)
            assert writer.wait(10) == -number
        assert len(list(tmp_path.iterdir())) == (3 if number == signal.SIGKILL else 2)
        _remove_left_parts.cache_clear()
        replace_text(tmp_path / "c.txt", "new")
        names = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
        assert len(list(tmp_path.iterdir())) == 3, "the part of the one that still writes stays"
        bystander.terminate()
    assert names == {"a.txt", "c.txt"}
    assert file.read_text() == "old"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems limit files in another way")
def test_temporary_files_without_room_are_not_blamed_on_the_scan(tmp_path):
    write(tmp_path / "a.laz", PointCloud(np.random.default_rng(0).normal(size=(4000, 3))))
    code = "import sys, lpcompare; lpcompare.read(sys.argv[1])"
    words = "ulimit -f 60; exec " + shlex.join([sys.executable, "-c", code, str(tmp_path / "a.laz")])
    done = subprocess.run(
        words, shell=True, capture_output=True, text=True, check=False, executable="/bin/bash"
    )
    assert "has no room for the points of" in done.stderr
    assert "TMPDIR" in done.stderr


def test_no_signal_is_caught_once_a_file_is_written(tmp_path):
    replace_text(tmp_path / "a.txt", "new")
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_a_link_stays_and_its_file_is_replaced(tmp_path):
    (tmp_path / "real.ply").write_text("old")
    (tmp_path / "link.ply").symlink_to("real.ply")
    write(tmp_path / "link.ply", CLOUD)
    assert (tmp_path / "link.ply").is_symlink()
    assert len(read(tmp_path / "real.ply")) == 3


def test_a_link_to_nowhere_names_the_folder_that_is_missing(tmp_path):
    (tmp_path / "link.ply").symlink_to("nowhere/a.ply")
    with pytest.raises(InputError, match=f"{tmp_path}/nowhere does not exist"):
        write(tmp_path / "link.ply", CLOUD)


@pytest.mark.parametrize("suffix", [".xyz", ".ply", ".laz", ".npy"])
def test_a_file_that_another_program_still_writes_is_no_cloud(suffix, tmp_path, monkeypatch):
    """It grows while it is read, or after its rows were chosen."""
    path, target = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    write(path, CLOUD)
    state = state_of(path)
    assert keep_rows(path, target, np.array([0]), state) == ()
    with path.open("ab") as file:
        file.write(path.read_bytes())
    with pytest.raises(InputError, match="changed while it was read"):
        keep_rows(path, target, np.array([0]), state)
    monkeypatch.setattr("lpcompare.io.formats.state_of", lambda _: state)
    with pytest.raises(InputError, match="changed while it was read"):
        read(path)
    monkeypatch.undo()
    assert len(read(target)) == 1, "what was there stays"


def test_standard_input_is_no_missing_file():
    with pytest.raises(InputError, match="Standard input cannot be read"):
        read("-")


@pytest.mark.parametrize(
    "suffix", [".ply", ".obj", ".off", ".xyz", ".csv", ".npy", ".npz", ".pcd", ".las", ".laz"]
)
@pytest.mark.parametrize("name", [b"br\xfccke", "橋 und Brücke".encode(), b"a'\"$(x);b\t", b"n" * 251])
def test_names_of_any_bytes(suffix, name, tmp_path):
    path = tmp_path / os.fsdecode(name[: 255 - len(suffix)] + suffix.encode())
    write(path, CLOUD)
    assert np.allclose(read(path).points, CLOUD.points)
    keep_rows(path, path, np.array([0, 2]))
    assert len(read(path)) == 2


@pytest.mark.parametrize("name", [b"br\xfccke.stl", "Brücke.stl".encode(), b"n" * 251 + b".stl"])
def test_names_of_any_bytes_for_meshlab(name, tmp_path):
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])))
    layers.save_current_mesh(str(tmp_path / "a.stl"))
    path = tmp_path / os.fsdecode(name)
    (tmp_path / "a.stl").rename(path)
    assert len(read(path)) == 3


def test_a_missing_input_is_not_blamed_on_the_output(tmp_path):
    with pytest.raises(InputError, match=r"nosuch\.ply cannot be read: No such file"):
        keep_rows(tmp_path / "nosuch.ply", tmp_path / "out.ply", np.array([0]))
