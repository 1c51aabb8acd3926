"""The README's Python session runs, word for word."""

import re
from pathlib import Path

import numpy as np
import pytest

import lpcompare

README = Path(__file__).resolve().parents[2] / "README.md"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    points = np.random.default_rng(0).normal(size=(2000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    lpcompare.write(tmp_path / "scan.ply", lpcompare.PointCloud(points))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_scan_becomes_a_study_in_twelve_lines(folder):
    session = next(
        b
        for b in re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
        if "lp.run" in b
    )
    assert len([line for line in session.splitlines() if line]) <= 12
    names = {}
    exec(compile(session, str(README), "exec"), names)
    assert list(names["errors"].index) == [0.7, 0.9]
    assert set(names["errors"].columns) == {"lp_uniform", "voxel_nearest"}
    for file in ("thin.ply", "errors.png", "page.html"):
        assert (folder / file).stat().st_size > 1000
