"""Every code block of the README and of docs/ runs, page by page, from top to bottom in one folder.

A block of Python or of the shell is left out only under a comment that says why: ``<!-- not run: reason -->``.
A block under ``<!-- needs: NAME -->`` needs a package or a program; without it the rest of the page still runs.
"""

import doctest
import os
import re
import shlex
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path
from shutil import which

import numpy as np
import pytest
from typer.testing import CliRunner

import lpcompare
from lpcompare.cli import build_app

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(
    r"(?:<!-- (not run|needs): ([^>]+) -->\n)?^```(python|sh|bash|console)\n(.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
APART = {"upstream.md": "tests/integration/test_upstream.py runs it"}


def blocks(page):
    return [match.groups() for match in BLOCK.finditer(page.read_text(encoding="utf-8"))]


def pages():
    return [
        pytest.param(p, id=p.relative_to(ROOT).as_posix()) for p in PAGES if p.name not in APART and blocks(p)
    ]


def present(name):
    return which(name) is not None or find_spec(name) is not None


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with two scans, and the words lpcompare and python on the search path."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(2000, 3)) * [1.0, 0.8, 0.6]
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    intensity = rng.integers(0, 255, 2000).astype(np.uint16)
    cloud = lpcompare.PointCloud(points, normals=points, attributes={"intensity": intensity})
    (tmp_path / "work").mkdir()
    for name in ("scan.ply", "scan.laz"):
        lpcompare.write(tmp_path / "work" / name, cloud)
    for word, module in (("lpcompare", "-m lpcompare.cli"), ("python", "")):
        script = tmp_path / word
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" {module} "$@"\n')
        script.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def run_python(code, names, page):
    if ">>>" not in code:
        exec(compile(code, str(page), "exec"), names)
        return
    session = doctest.DocTestParser().get_doctest(code, names, page.name, str(page), 0)
    said = []
    result = doctest.DocTestRunner(verbose=False).run(session, out=said.append, clear_globs=False)
    names.update(session.globs)
    assert result.failed == 0, "".join(said)


def run_shell(text):
    """Line by line; plain lines of lpcompare run in this process, which has its libraries at hand."""
    for line in text.splitlines():
        if line.startswith("lpcompare ") and not set("|<>&;$") & set(line):
            said = CliRunner().invoke(build_app(), shlex.split(line, comments=True)[1:])
            assert said.exit_code == 0, (line, said.output, said.exception)
        else:
            words = ["bash", "-euo", "pipefail", "-c", line]
            done = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
            assert done.returncode == 0, line + done.stdout + done.stderr


@pytest.mark.parametrize("page", pages())
def test_every_block_of_a_page_runs(page, folder):
    plane = (
        Path(find_spec("pymeshlab").submodule_search_locations[0])
        / "tests/sample_meshes/colored_airplane.ply"
    )
    names = {"SCAN": str(plane), "OUT": str(folder / "out.ply"), "SCRIPT": str(folder / "script.mlx")}
    absent = []
    for condition, what, language, code in blocks(page):
        if condition == "not run":
            continue
        if condition == "needs" and not present(what):
            absent.append(what)
            continue
        run_python(code, names, page) if language == "python" else run_shell(code)
    if absent:
        pytest.skip(f"the other blocks ran; not installed: {', '.join(absent)}")


def test_the_method_of_the_guide_is_found_and_keeps_the_contract(tmp_path):
    """docs/guides/adding.md: its file and its entry point, installed as a package of their own."""
    text = (ROOT / "docs" / "guides" / "adding.md").read_text(encoding="utf-8")
    code, entry = (re.search(rf"```{kind}\n(.*?)```", text, re.DOTALL)[1] for kind in ("python", "toml"))
    (group,) = tomllib.loads(entry)["project"]["entry-points"].items()
    ((name, module),) = group[1].items()
    file = tmp_path.joinpath(*module.split(".")).with_suffix(".py")
    file.parent.mkdir()
    file.write_text(code)
    info = tmp_path / "mine-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{group[0]}]\n{name} = {module}\n")
    check = f"from lpcompare.testing import check_method; check_method({name!r})"
    done = subprocess.run(
        [sys.executable, "-c", check],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_blocks_that_are_left_out_are_few_and_say_why():
    left_out = [what for page in PAGES for condition, what, _, _ in blocks(page) if condition == "not run"]
    assert all(len(reason) > 10 for reason in left_out)
    assert len(left_out) < 0.3 * sum(len(blocks(page)) for page in PAGES if page.name not in APART)
