"""The command line as its users meet it: in processes of its own, beside methods that misbehave."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lpcompare.processes.children import Children

PLUGINS = Path(__file__).resolve().parents[1] / "plugins"


@pytest.fixture(scope="session")
def plugin_environment(tmp_path_factory):
    """Environment variables with which lpcompare finds the methods of tests/plugins/naughty."""
    folder = tmp_path_factory.mktemp("site")
    info = folder / "naughty-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: naughty\nVersion: 1.0\n")
    names = [path.stem for path in (PLUGINS / "naughty").glob("[a-z]*.py")]
    lines = "".join(f"{name} = naughty.{name}\n" for name in names)
    (info / "entry_points.txt").write_text(f"[lpcompare.methods]\n{lines}")
    return os.environ | {"PYTHONPATH": f"{folder}{os.pathsep}{PLUGINS}"}


@pytest.fixture(scope="session")
def lpcompare(plugin_environment):
    """Run the command line in a forked process (command.py); returns the finished process with its text."""
    with pytest.MonkeyPatch.context() as patch, Children() as children:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=os.pathsep)
        children.prepare("command")

        def run(*words, cwd=None, timeout=120):
            words = [json.dumps(plugin_environment), *map(str, words)]
            limits = {"time_limit_s": timeout, "memory_limit_mib": 2**20}
            ending = children.call("command", *words, folder=Path(cwd or ".").resolve(), **limits)
            assert ending.code is not None, ending
            return subprocess.CompletedProcess(words, ending.code, ending.answer, ending.errors)

        yield run


@pytest.fixture(scope="session")
def program(plugin_environment):
    """Run the command line as a program, with nobody who ends what it leaves; returns the finished process."""

    def run(*words, timeout=120):
        return subprocess.run(
            [sys.executable, "-m", "lpcompare.cli", *map(str, words)],
            env=plugin_environment,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )

    return run


@pytest.fixture(scope="session")
def cloud_file(tmp_path_factory):
    """A file with 500 points on a sphere."""
    points = np.random.default_rng(1).normal(size=(500, 3))
    path = tmp_path_factory.mktemp("clouds") / "ball.npy"
    np.save(path, points / np.linalg.norm(points, axis=1, keepdims=True))
    return path
