"""The committed study of Pauly, Gross and Kobbelt: its text is what its records say, to the letter."""

from pathlib import Path

from reports.pauly.make import page, read_records

FOLDER = Path(__file__).resolve().parents[2] / "reports" / "pauly"


def test_the_page_is_made_from_the_records():
    assert (FOLDER / "README.md").read_text(encoding="utf-8") == page(read_records())
