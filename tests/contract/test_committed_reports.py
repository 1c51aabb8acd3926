"""The README, docs/ and the pages under reports/: their numbers are those of the committed files, to the letter."""

import runpy
from pathlib import Path

import pytest

from lpcompare.benchmark.record import load_run
from lpcompare.report.page_markdown import write_study_page

ROOT = Path(__file__).resolve().parents[2]
REPORTS = ROOT / "reports"


def readme():
    return (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_claim_of_the_readme_is_what_the_committed_files_say():
    assert runpy.run_path(str(REPORTS / "claims.py"))["table"]() in readme()


@pytest.mark.parametrize("study", ["bunny", "methods", "robustness"])
def test_the_page_of_a_study_is_made_from_its_run(study, tmp_path):
    page = write_study_page(load_run(REPORTS / study), tmp_path / "README.md", "poisson_disk")
    assert (REPORTS / study / "README.md").read_text(encoding="utf-8") == page.read_text(encoding="utf-8")


def test_the_tables_of_the_uniform_study_stand_on_its_page():
    page = (REPORTS / "uniform" / "README.md").read_text(encoding="utf-8")
    ratios = runpy.run_path(str(REPORTS / "uniform" / "ratios.py"))
    cases = ratios["read"](REPORTS / "uniform" / "records.csv")
    tables = [ratios["summary"](cases), *(ratios["by_case"](cases, m) for m in ("lp_uniform", "lp_placed"))]
    assert all("\n".join(lines) in page for lines in tables)


MAKE = runpy.run_path(str(ROOT / "docs" / "make.py"))


def test_the_made_parts_of_the_pages_are_what_code_and_reports_say():
    stale = [
        path.name
        for path, text in MAKE["pages"]()
        if path.read_text(encoding="utf-8").strip() != text.strip()
    ]
    assert not stale, "run python docs/make.py"


def test_the_default_method_is_what_the_page_of_choices_recommends():
    """docs/which-method.md says so in its first sentences."""
    shape = next(line for line in MAKE["choice"]() if "eq. 27" in line)
    assert shape.split("|")[2].strip().startswith("`lp_uniform`")
