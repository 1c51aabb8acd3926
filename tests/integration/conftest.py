"""The command line as its users meet it: in processes of its own, beside methods that misbehave."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

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
    """Run the command line; returns the finished process with its text."""

    def run(*words, cwd=None, timeout=120):
        return subprocess.run(
            [sys.executable, "-m", "lpcompare.cli", *map(str, words)],
            env=plugin_environment,
            cwd=cwd,
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
