"""The study of the paper is continued from the same commit, and made anew from another."""

import json

import pytest
from reports.paper.make import _begin


@pytest.mark.parametrize(
    ("before", "now", "kept"),
    [("a1", "a1", True), ("a1", "a1+", True), ("a1+", "a1", True), ("a1", "b2", False), (None, "b2", True)],
)
def test_rows_of_another_commit_are_not_kept(tmp_path, before, now, kept):
    (tmp_path / "errors.csv").write_text("model,error\n")
    if before:
        (tmp_path / "made.json").write_text(json.dumps({"commit": before}))
    made = _begin(tmp_path, {"commit": now})
    assert (tmp_path / "errors.csv").exists() == kept
    assert made == {"commit": now} == json.loads((tmp_path / "made.json").read_text())
