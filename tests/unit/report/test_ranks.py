"""Ranks against worked examples, and what cannot be ranked."""

import math

import pandas as pd
import pytest
from frames import record, table_of
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kendalltau

from lpcompare.report.cells import columns
from lpcompare.report.ranks import (
    Ranking,
    agreement,
    agreement_table,
    rank_over_cells,
    rank_over_models,
    reversals,
)
from lpcompare.types import Column


def cells(table, reduction=0.9):
    """Cells from {model: {method: error}}."""
    return table_of(
        *(
            record(method, reduction, error=error, model=model)
            for model, row in table.items()
            for method, error in row.items()
        )
    )


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
    table = {f"set {i}": {m: 1 - a for m, a in zip(names, row, strict=True)} for i, row in enumerate(DEMSAR)}
    ranking = rank_over_models(cells(table))
    assert ranking.ranks.to_dict() == pytest.approx(
        {"C4.5": 3.143, "C4.5+m": 2.000, "C4.5+cf": 2.893, "C4.5+m+cf": 1.964}, abs=1e-3
    )
    assert ranking.critical_difference == pytest.approx(2.569 * math.sqrt(4 * 5 / (6 * 14)), rel=1e-3)
    assert ranking.decided


def test_a_method_without_every_model_is_left_out_by_name():
    ranking = rank_over_models(cells({"a": {"x": 1, "y": 2}, "b": {"x": 1}}))
    assert list(ranking.ranks.index) == ["x"]
    assert ranking.left_out == ("y",)


def test_a_method_that_misses_a_reduction_is_left_out():
    both = pd.concat([cells({"a": {"x": 1, "y": 2}}, 0.8), cells({"a": {"x": 1}}, 0.9)])
    assert rank_over_models(both).left_out == ("y",)


def test_two_models_are_ranked_and_not_tested():
    ranking = rank_over_models(cells({m: {"x": 1, "y": 2, "z": 3} for m in "ab"}))
    assert ranking.ranks.to_list() == [1.0, 2.0, 3.0]
    assert math.isnan(ranking.p_value)
    assert not ranking.decided


def test_no_cells_rank_nobody():
    assert rank_over_cells(table_of()).ranks.empty
    assert rank_over_models(table_of()).ranks.empty


def ranked(*methods):
    return Ranking(pd.Series(range(1, len(methods) + 1), methods, dtype=float), 1, ())


@given(st.lists(st.tuples(st.integers(1, 6), st.integers(1, 6)), min_size=2, max_size=30))
def test_agreement_is_kendalls_tau_b_ties_or_not(pairs):
    names = [f"m{i}" for i in range(len(pairs))]
    one, other = (Ranking(pd.Series(ranks, names, dtype=float), 1, ()) for ranks in zip(*pairs, strict=True))
    if one.ranks.nunique() == 1 or other.ranks.nunique() == 1:
        assert math.isnan(agreement(one, other))
    else:
        assert agreement(one, other) == pytest.approx(kendalltau(one.ranks, other.ranks).statistic)


def test_agreement_is_one_for_the_same_order_and_minus_one_for_the_reverse():
    assert agreement(ranked("a", "b", "c"), ranked("a", "b", "c")) == pytest.approx(1)
    assert agreement(ranked("a", "b", "c"), ranked("c", "b", "a")) == pytest.approx(-1)
    assert math.isnan(agreement(ranked("a"), ranked("a")))


def test_reversals_name_neighbours_that_swap():
    assert reversals(ranked("a", "b", "c"), ranked("b", "a", "c")) == [("a", "b")]
    assert reversals(ranked("a", "b"), ranked("a", "b")) == []


def test_measures_are_set_beside_eq_27_and_an_alias_is_not_counted():
    metrics = {"a": {"hausdorff_pct": 2.0, "twin": 2.0}, "b": {"hausdorff_pct": 1.0, "twin": 1.0}}
    table = table_of(*(record(m, error=e, metrics=metrics[m]) for m, e in (("a", 1), ("b", 2))))
    known = columns(table) | {"twin": Column("", "Twin", alias="hausdorff_pct")}
    found = agreement_table(table, known).set_index("key")
    assert list(found.index) == ["plane_error_pct", "hausdorff_pct"]
    assert found.tau.to_list() == [1, -1]
    assert found.reversed_pairs["hausdorff_pct"] == [("a", "b")]


def test_the_methods_that_differ_from_the_first_are_named():
    ranking = Ranking(pd.Series({"a": 1.0, "b": 1.5, "c": 3.0}), 9, (), 0.01, 1.0)
    assert ranking.worse == ["c"]
    assert ranking.leaders == ("a",)
