"""docs/upstream.md: every bug of another program is still what the page says, at the version that it names."""

import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "upstream.md"
PROGRAM = re.compile(r"^## .*?\((\S+) (\S+)\)$(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
HANGS = "still running after five seconds"
BUG = re.compile(r"^### (.*?)$.*?```python\n(.*?)```.*?```text\n(.*?)\n```", re.MULTILINE | re.DOTALL)


def bugs():
    for package, number, text in PROGRAM.findall(PAGE.read_text(encoding="utf-8")):
        for title, code, end in BUG.findall(text):
            yield pytest.param(package, number, code, end, id=f"{package}: {title}")


def how_it_ends(code, folder, patience):
    try:
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=patience,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return HANGS
    return "crash" if done.returncode < 0 else done.stdout.strip() if done.returncode == 0 else done.stderr


def test_every_heading_is_a_bug_with_its_end():
    text = PAGE.read_text(encoding="utf-8")
    assert len(list(bugs())) == text.count("\n### ") == text.count("```text")


@pytest.mark.parametrize(("package", "number", "code", "end"), list(bugs()))
def test_it_ends_as_the_page_says(package, number, code, end, tmp_path):
    try:
        installed = version(package)
    except PackageNotFoundError:
        pytest.skip(f"{package} is not installed")
    if installed != number:
        pytest.skip(f"the page speaks of {package} {number}; {installed} is installed")
    assert how_it_ends(code, tmp_path, 5 if end == HANGS else 60) == end
