"""The page of methods names every method, with its flags, and imports none."""

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from lpcompare.registry import METHODS

PAGE = Path(__file__).parents[3] / "docs" / "methods_page.py"


@pytest.fixture(scope="module")
def page():
    return runpy.run_path(str(PAGE))["method_page"]()


@pytest.mark.parametrize("name", METHODS.names())
def test_every_method_has_a_row_and_a_source(name, page):
    row = next(line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
    traits = METHODS.traits(name)
    cells = [cell.strip() for cell in row.strip("|").split(" | ")]
    assert len(cells) == 7
    assert cells[3] == ("new points" if traits.moves_points else "subset")
    assert cells[4] == ("exact" if traits.exact_count else "near")
    assert ("mesh" in cells[2].split(", ")) == traits.needs_mesh
    assert cells[6] == traits.licence
    assert f"- `{name}`: {traits.wraps}." in page


def test_at_least_fourteen_methods_need_no_extra():
    assert sum(not METHODS.traits(name).extra for name in METHODS) >= 14


def test_the_page_imports_no_rival():
    code = (
        f"import runpy, sys; runpy.run_path({str(PAGE)!r})['method_page'](); "
        "rivals = 'pymeshlab', 'fast_simplification', 'CGAL', 'open3d', 'cvxpy'; "
        "print([name for name in rivals if name in sys.modules])"
    )
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert child.stdout.strip() == "[]"
