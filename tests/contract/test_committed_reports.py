"""The README and the pages under reports/: their numbers are those of the committed files, to the letter."""

import runpy
from pathlib import Path

import pytest

from lpcompare.benchmark.record import load_run
from lpcompare.report.page_markdown import method_page, write_study_page
from lpcompare.report.tables import format_run

ROOT = Path(__file__).resolve().parents[2]
REPORTS = ROOT / "reports"


def readme():
    return (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_claim_of_the_readme_is_what_the_committed_files_say():
    assert runpy.run_path(str(REPORTS / "claims.py"))["table"]() in readme()


def test_the_readmes_table_is_the_one_that_the_committed_run_prints():
    last = format_run(load_run(REPORTS / "bunny")).split("\n\n")[2]
    assert "90 % removed" in last
    assert last in readme()


@pytest.mark.parametrize("study", ["bunny", "methods"])
def test_the_page_of_a_study_is_made_from_its_run(study, tmp_path):
    page = write_study_page(load_run(REPORTS / study), tmp_path / "README.md", "poisson_disk")
    assert (REPORTS / study / "README.md").read_text(encoding="utf-8") == page.read_text(encoding="utf-8")


def test_the_tables_of_the_uniform_study_stand_on_its_page():
    page = (REPORTS / "uniform" / "README.md").read_text(encoding="utf-8")
    ratios = runpy.run_path(str(REPORTS / "uniform" / "ratios.py"))
    cases = ratios["read"](REPORTS / "uniform" / "records.csv")
    tables = [ratios["summary"](cases), *(ratios["by_case"](cases, m) for m in ("lp_uniform", "lp_placed"))]
    assert all("\n".join(lines) in page for lines in tables)


def test_the_page_of_methods_is_made_from_their_files():
    assert (ROOT / "docs" / "methods.md").read_text(encoding="utf-8").strip() == method_page().strip()
