"""``lpcompare report`` as its users meet it."""

import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from made_runs import plain_run  # noqa: F401


def test_everything_is_written_and_named_line_by_line(lpcompare, plain_run, tmp_path):  # noqa: F811
    run = tmp_path / "run"
    shutil.copytree(plain_run, run)
    done = lpcompare(
        "report", run, "--latex", "--markdown", "--csv", "--meshlab", "--reference", "first_rows"
    )
    assert done.returncode == 0, done.stderr
    named = [Path(line) for line in done.stdout.split()]
    assert named == [
        run / "report.html",
        run / "tables.tex",
        run / "tables.md",
        run / "cells.csv",
        run / "meshlab/dented.mlp",
    ]
    assert all(path.stat().st_size for path in named)
    assert not list(run.rglob("*.part"))


@pytest.mark.parametrize("content", ["", '{"schema_version": 1, "records": [', '{"cells": []}', "42", None])
def test_a_run_json_that_is_none_is_one_sentence_and_exit_code_2(lpcompare, tmp_path, content):
    if content is not None:
        (tmp_path / "run.json").write_text(content)
    done = lpcompare("report", tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("report.html*"))


def test_an_unknown_reference_is_one_sentence_and_exit_code_2(lpcompare, plain_run, tmp_path):  # noqa: F811
    done = lpcompare("report", plain_run, "--out", tmp_path / "p.html", "--reference", "first_row")
    assert done.returncode == 2
    assert "Did you mean 'first_rows'?" in done.stderr


def test_a_run_is_not_replaced_by_its_page(lpcompare, plain_run, tmp_path):  # noqa: F811
    run = tmp_path / "run"
    shutil.copytree(plain_run, run)
    before = (run / "run.json").read_bytes()
    done = lpcompare("report", run, "--out", run / "run.json")
    assert (done.returncode, done.stdout) == (2, "")
    assert "name a file that ends in .html" in done.stderr
    assert (run / "run.json").read_bytes() == before
