"""Errors against perturbations: the curves, who suffers, and the paper's claim of robustness."""

from dataclasses import replace

import pandas as pd
import pytest
from frames import record as made
from frames import run_of

from lpcompare.benchmark.perturbation import LARGEST_LEVEL
from lpcompare.report.cells import LEVELS, perturbation_curves
from lpcompare.report.charts import collect_perturbations
from lpcompare.report.tables import NARROW, format_run


def record(method, kind, level, error, status="ok"):
    return made(
        method, 0.8, status=status, error=error, model="ball", perturbation=kind, perturbation_level=level,
        metrics={"plane_error_pct": error},
    )  # fmt: skip


def run_with(kind, printed, others):
    """Every method at 0.1 % on the clean cloud and at ``growth`` times that on the perturbed one."""
    growths = {"lp_printed": printed, **{f"other_{i}": g for i, g in enumerate(others)}}
    rows = [record(name, "none", 0.0, 0.1) for name in growths]
    return rows + [record(name, kind, 0.5, 0.1 * growth) for name, growth in growths.items()]


def text_of(records):
    """The table of the perturbed inputs, which stands between that of the clean ones and the legend."""
    text = format_run(run_of(records))
    assert max(map(len, text.splitlines())) <= NARROW
    return " ".join(text.split("\n\n")[1].split())


@pytest.mark.parametrize("kind", ["noise", "outliers"])
def test_the_claim_is_confirmed_when_most_others_suffer_more(kind):
    text = text_of(run_with(kind, 1.5, [1.2, 2.0, 3.0]))
    assert "grows 1.50 times (median of the other methods 2.00) and is 0.1500 (median 0.2000)" in text
    assert "the claim is confirmed" in text


def test_the_claim_is_refuted_when_most_others_suffer_less():
    assert "the claim is refuted" in text_of(run_with("noise", 2.5, [1.2, 2.0, 3.0]))
    assert "the claim is refuted" in text_of(run_with("noise", 2.0, [2.0])), "as much is not less"


def test_little_growth_from_a_large_error_is_not_robust():
    rows = run_with("noise", 1.1, [1.2, 2.0, 3.0])
    worse = [replace(r, metrics={"plane_error_pct": 3 * r.metrics["plane_error_pct"]}) for r in rows]
    rows = [w if r.method == "lp_printed" else r for r, w in zip(rows, worse, strict=True)]
    assert "the claim is refuted" in text_of(rows)


def test_the_paper_claims_nothing_of_missing_regions():
    text = text_of(run_with("missing", 1.5, [1.2, 2.0]))
    assert "claim" not in text
    assert "the error of other_0 grows least (1.20 times" in text


def test_a_failed_case_has_no_growth_and_is_not_counted():
    rows = run_with("noise", 1.5, [2.0, 3.0])
    failed = record("other_1", "noise", 0.5, 0.1, status="failed")
    assert "(median of the other methods 2.00)" in text_of([*rows[:-1], failed])


def test_curves_start_at_the_clean_cloud_and_average_the_seeds():
    rows = [*run_with("noise", 1.5, []), record("lp_printed", "noise", 0.5, 0.25)]
    curves = perturbation_curves(run_of(rows).frame)
    assert curves.loc[("ball", 0.8, "noise", "lp_printed")].to_dict() == {0.0: 0.1, 0.5: pytest.approx(0.2)}


def test_nothing_perturbed_has_no_curve():
    assert perturbation_curves(run_of(run_with("noise", 1.5, [])[:1]).frame).equals(pd.DataFrame())


def test_the_page_is_given_the_curves_without_what_has_no_result_and_who_saw_no_outlier():
    rows = [*run_with("outliers", 1.5, [2.0]), record("crasher", "outliers", 0.5, 0.1, status="failed")]
    rows = [replace(r, needs_mesh=r.method == "other_0") for r in rows]
    shown = collect_perturbations(run_of(rows).frame)
    (panel,) = shown["panels"]
    assert panel["curves"]["lp_printed"] == [(0.0, 0.1), (0.5, pytest.approx(0.15))]
    assert panel["curves"].keys() == {"lp_printed", "other_0"}
    assert (shown["models"], shown["reductions"], list(shown["kinds"])) == (["ball"], [0.8], ["outliers"])
    assert shown["blind"] == ["other_0"]
    assert collect_perturbations(run_of(rows[:2]).frame)["panels"] == []


def test_every_kind_of_perturbation_has_a_caption():
    assert LEVELS.keys() == LARGEST_LEVEL.keys() - {"none"}
