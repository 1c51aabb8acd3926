"""Ranks against worked examples, and what cannot be ranked."""

import math

import pytest

from lpcompare.report.cells import Cell, Interval
from lpcompare.report.columns import Heading
from lpcompare.report.ranks import Ranking, agreement, rank_over_cells, rank_over_models, reversals

ERROR = Heading("e", "Error")


def cells(table, reduction=0.9):
    """Cells from {model: {method: error}}."""
    return [
        Cell(model, method, reduction, 100, 10, {"ok": 1}, values={"e": Interval.of([error])})
        for model, row in table.items()
        for method, error in row.items()
    ]


# Demsar (2006), table 6: AUC of C4.5 and three variants on 14 data sets, as published.
DEMSAR = [
    (0.763, 0.768, 0.771, 0.798), (0.599, 0.591, 0.590, 0.569), (0.954, 0.971, 0.968, 0.967),
    (0.628, 0.661, 0.654, 0.657), (0.882, 0.888, 0.886, 0.898), (0.936, 0.931, 0.916, 0.931),
    (0.661, 0.668, 0.609, 0.685), (0.583, 0.583, 0.563, 0.625), (0.775, 0.838, 0.866, 0.875),
    (1.000, 1.000, 1.000, 1.000), (0.940, 0.962, 0.965, 0.962), (0.619, 0.666, 0.614, 0.669),
    (0.972, 0.981, 0.9751, 0.975), (0.957, 0.978, 0.946, 0.970),
]  # fmt: skip


def test_ranks_and_critical_difference_of_the_textbook_example():
    names = ("C4.5", "C4.5+m", "C4.5+cf", "C4.5+m+cf")
    table = {f"set {i}": dict(zip(names, row, strict=True)) for i, row in enumerate(DEMSAR)}
    ranking = rank_over_models(cells(table), Heading("e", "AUC", better="higher"))
    ranks = dict(zip(ranking.methods, ranking.mean_ranks, strict=True))
    assert ranks == pytest.approx(
        {"C4.5": 3.143, "C4.5+m": 2.000, "C4.5+cf": 2.893, "C4.5+m+cf": 1.964}, abs=1e-3
    )
    assert ranking.critical_difference == pytest.approx(2.569 * math.sqrt(4 * 5 / (6 * 14)), rel=1e-3)
    assert ranking.decided


def test_a_method_without_every_model_is_left_out_by_name():
    ranking = rank_over_models(cells({"a": {"x": 1, "y": 2}, "b": {"x": 1}}), ERROR)
    assert ranking.methods == ("x",)
    assert ranking.left_out == ("y",)


def test_a_method_that_misses_a_reduction_is_left_out():
    both = cells({"a": {"x": 1, "y": 2}}, 0.8) + cells({"a": {"x": 1}}, 0.9)
    assert rank_over_models(both, ERROR).left_out == ("y",)


def test_two_models_are_ranked_and_not_tested():
    ranking = rank_over_models(cells({m: {"x": 1, "y": 2, "z": 3} for m in "ab"}), ERROR)
    assert ranking.mean_ranks == (1.0, 2.0, 3.0)
    assert math.isnan(ranking.p_value)
    assert not ranking.decided


def test_no_cells_rank_nobody():
    assert rank_over_cells([], ERROR).methods == ()


def ranked(*methods):
    return Ranking(methods, tuple(range(1, len(methods) + 1)), (), ())


def test_agreement_is_one_for_the_same_order_and_minus_one_for_the_reverse():
    assert agreement(ranked("a", "b", "c"), ranked("a", "b", "c")) == pytest.approx(1)
    assert agreement(ranked("a", "b", "c"), ranked("c", "b", "a")) == pytest.approx(-1)
    assert math.isnan(agreement(ranked("a"), ranked("a")))


def test_reversals_name_neighbours_that_swap():
    assert reversals(ranked("a", "b", "c"), ranked("b", "a", "c")) == [("a", "b")]
    assert reversals(ranked("a", "b"), ranked("a", "b")) == []
