"""The spread over seeds: coefficients by hand, and what the sentences say."""

import runpy
from pathlib import Path

import pytest
from tests.unit.report.frames import record, run_of

SPREAD = runpy.run_path(str(Path(__file__).resolve().parents[3] / "reports" / "seeds" / "spread.py"))
ERRORS = {"lp_uniform": (1.0, 1.2), "poisson_disk": (1.1, 2.1), "cgal_random": (3.0, 3.0)}


def run():
    rows = [record(m, error=e) for m, errors in ERRORS.items() for e in errors]
    return run_of([*rows, record("lp_uniform", status="failed")])


def test_a_coefficient_is_the_deviation_over_the_mean():
    shares = SPREAD["coefficients"](run().frame, ["plane_error_pct"]).plane_error_pct
    assert shares["lp_uniform"] == pytest.approx(0.02**0.5 / 1.1)
    assert shares["cgal_random"] == 0


def test_the_sentences_name_the_most_and_the_least_and_count_the_pairs():
    text = "\n".join(SPREAD["spread"](run(), {"plane_error_pct": "plane error"}))
    assert "plane error of `poisson_disk` most (44.2 %)" in text
    assert "`cgal_random` least (0.0 %)" in text
    assert "lower plane error than `poisson_disk` in 3 of 4 pairs" in text
    assert "| `lp_uniform` | 12.9 % |" in text
