"""Repeats become cells; cells know their ratios and their front."""

import math

import numpy as np
import pandas as pd
import pytest
from frames import record, run_of, table_of
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.report.cells import (
    cells,
    choose_reference,
    clean,
    columns,
    mean_ratios,
    pareto_front,
    ratios,
    witnesses,
)
from lpcompare.types import Column


def test_median_and_range_of_the_repeats():
    table = table_of(*(record(repeat=i, runtime_s=t) for i, t in enumerate((3.0, 1.0, 7.0))))
    assert table[["runtime_s", "runtime_s_low", "runtime_s_high"]].to_numpy().tolist() == [[3.0, 1.0, 7.0]]
    assert (table.n_repeats[0], table.n_ok[0], table.status[0]) == (3, 3, "ok")


def test_a_failed_repeat_is_counted_and_does_not_enter_the_median():
    table = table_of(record(repeat=0), record(repeat=1, status="failed"), record(repeat=2, runtime_s=3.0))
    (cell,) = table.itertuples()
    assert cell.runtime_s == 2.0
    assert (cell.status, cell.message, cell.n_ok) == ("2 ok, 1 failed", "why", 2)


def test_a_cell_without_a_result_keeps_its_reason_and_has_no_numbers():
    (cell,) = table_of(record(status="failed")).itertuples()
    assert (cell.status, cell.message, cell.n_ok) == ("failed", "why", 0)
    assert math.isnan(cell.plane_error_pct)


def test_a_metric_that_is_not_defined_is_no_column():
    table = table_of(record(metrics={"a": math.nan, "b": 1.0}))
    assert "a" not in columns(table)
    assert columns(table)["b"] == Column("", "b", better=""), "nobody says which direction is better"


def test_settings_perturbations_and_swaps_are_cells_of_their_own():
    table = table_of(
        record(),
        record(variant="f k=2"),
        record(perturbation="noise", perturbation_level=0.5),
        record(refined=True),
    )
    assert list(zip(table.input, table.label, strict=True)) == [
        ("m", "f"),
        ("m", "f k=2"),
        ("m + noise 0.5", "f"),
        ("m", "f + swaps"),
    ]
    assert list(clean(table).label) == ["f", "f k=2", "f + swaps"]


def test_no_record_is_no_cell():
    assert table_of().empty
    assert choose_reference(table_of()) == ""


def test_columns_are_titled_by_their_metric_and_an_alias_is_no_witness(monkeypatch):
    known = columns(table_of(record(metrics={"hausdorff_pct": 3.0})))
    assert list(known)[:3] == ["plane_error_pct", "n_output", "runtime_s"]
    assert known["hausdorff_pct"].unit == "% of diagonal"
    known["twin"] = Column("%", "Twin", alias="hausdorff_pct")
    assert witnesses(known) == ["plane_error_pct", "hausdorff_pct"]


def test_the_reference_is_poisson_disk_or_the_fastest_that_ended_most_often():
    slow, fast = record("slow", runtime_s=2.0), record("fast", runtime_s=1.0)
    assert choose_reference(table_of(slow, fast)) == "fast"
    assert choose_reference(table_of(slow, record("slow", 0.8, runtime_s=2.0), fast)) == "slow"
    assert choose_reference(table_of(slow, fast, record("poisson_disk", runtime_s=9.0))) == "poisson_disk"


def test_ratios_are_to_the_reference_of_the_same_input_and_reduction():
    rows = [
        record(m, r, error=e) for m, r, e in (("a", 0.8, 1), ("b", 0.8, 3), ("a", 0.9, 2), ("b", 0.9, 24))
    ]
    table = table_of(*rows, record("b", 0.5, error=1))
    found = ratios(table, "a", ["plane_error_pct"]).plane_error_pct
    assert found.to_list()[:4] == [1, 3, 1, 12]
    assert math.isnan(found.iloc[4])
    means, counts = mean_ratios(table, "a", ["plane_error_pct"])
    assert means.plane_error_pct["b"] == pytest.approx(6)
    assert counts.plane_error_pct["b"] == 2


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=30))
def test_no_cell_beats_one_of_the_front_and_each_other_is_matched_by_one(pairs):
    table = pd.DataFrame(pairs, columns=["t", "e"])
    front = pareto_front(table, "t", "e")
    assert len(front)
    for cost, error in pairs:
        assert not any((front.t >= cost) & (front.e > error))
        assert any((front.t <= cost) & (front.e <= error))


@settings(deadline=None, max_examples=20)
@given(st.permutations(range(6)))
def test_the_order_of_the_records_changes_no_number(order):
    rows = [record(m, 0.9, i, runtime_s=float(i + 1)) for m in "ab" for i in range(3)]
    table = cells(run_of([rows[i] for i in order]).frame).sort_values("label")
    assert np.array_equal(table.runtime_s, [2.0, 2.0])
