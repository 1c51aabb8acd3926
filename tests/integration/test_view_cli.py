"""``lpcompare view`` writes a page of a cloud or of a run, and opens it where there is a screen."""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from made_runs import plain_run  # noqa: F401

from lpcompare.cli import main
from lpcompare.io import write
from lpcompare.types import PointCloud


@pytest.fixture
def view(monkeypatch, capsys):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)

    def call(*words, screen=""):
        monkeypatch.setenv("DISPLAY", screen)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        monkeypatch.setattr(sys, "platform", "linux")
        monkeypatch.setattr(sys, "argv", ["lpcompare", "view", *map(str, words)])
        code = 0
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
        out = capsys.readouterr()
        return code, out.out, out.err, opened

    return call


@pytest.fixture
def scan(tmp_path):
    path = tmp_path / "scan.ply"
    write(path, PointCloud(np.random.default_rng(0).normal(size=(200, 3))))
    return path


def test_without_a_screen_it_says_where_the_page_is(view, scan, tmp_path):
    code, out, err, opened = view(scan, "--out", tmp_path / "scan.html")
    assert (code, out, err, opened) == (0, f"The page is {tmp_path / 'scan.html'}\n", "", [])
    assert "<html" in (tmp_path / "scan.html").read_text(encoding="utf-8")


def test_with_a_screen_it_opens_the_page(view, scan, tmp_path):
    assert view(scan, "--out", tmp_path / "a.html", screen=":0")[3] == [(tmp_path / "a.html").as_uri()]
    assert view(scan, "--out", tmp_path / "a.html", "--no-browser", screen=":0")[1].startswith("The page is")


def test_the_page_of_a_run_is_shown_too(view, plain_run, tmp_path):  # noqa: F811
    for target in (plain_run, plain_run / "run.json"):
        assert view(target, "--out", tmp_path / "page.html")[0] == 0
        assert "random_sample" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_what_is_not_there_is_one_sentence(view, tmp_path):
    code, out, err, _ = view(tmp_path / "nosuch.ply")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "Did you mean 'bunny'" in view("buny")[2]


def test_what_is_shown_is_not_replaced_by_its_page(view, scan, tmp_path):
    before = scan.read_bytes()
    (tmp_path / "link.html").symlink_to(scan)
    for out in (scan, tmp_path / "link.html"):
        code, _, err, _ = view(scan, "--out", out)
        assert (code, scan.read_bytes()) == (2, before)
        assert "is no name of a page; name a file that ends in .html" in err


def test_points_without_coordinates_are_left_out_and_said(view, tmp_path):
    points = np.random.default_rng(0).normal(size=(200, 3))
    points[:3] = np.nan
    write(tmp_path / "scan.ply", PointCloud(points))
    code, _, err, _ = view(tmp_path / "scan.ply", "--out", tmp_path / "a.html")
    assert code == 0
    assert "3 of 200 points have no finite coordinates and are left out" in err


@pytest.mark.parametrize(("value", "reason"), [(np.nan, "NaN"), (1e300, "rescale them")])
def test_a_cloud_that_cannot_be_drawn_is_one_sentence(value, reason, view, tmp_path):
    write(tmp_path / "scan.ply", PointCloud(np.full((5, 3), value)))
    code, out, err, _ = view(tmp_path / "scan.ply", "--out", tmp_path / "a.html")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert reason in err


def test_a_name_in_no_script_of_this_machine(view, scan, tmp_path):
    odd = scan.rename(tmp_path / os.fsdecode(b"br\xfccke.ply"))
    assert view(odd, "--out", tmp_path / "a.html")[0] == 0


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_that_is_none_is_one_sentence(port, view, plain_run):  # noqa: F811
    code, _, err, _ = view(plain_run, "--serve", "--port", port)
    assert (code, err) == (2, f"lpcompare: port is {port}; give an integer from 0 to 65535.\n")


def test_what_cannot_be_shown_leaves_no_folder(view, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "broken.ply").write_text("ply")
    assert view(tmp_path / "broken.ply")[0] == 2
    assert [path.name for path in tmp_path.iterdir()] == ["broken.ply"]
