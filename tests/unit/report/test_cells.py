"""Repeats become cells; cells know their front."""

import math

from hypothesis import given
from hypothesis import strategies as st

from lpcompare.benchmark.record import Record
from lpcompare.report.cells import Cell, Interval, gather_cells, pareto_front


def record(repeat=0, status="ok", **known):
    defaults = (
        {"runtime_s": 1.0, "metrics": {"plane_error_pct": 2.0}} if status == "ok" else {"message": "why"}
    )
    return Record("m", "f", 0.9, 100, 10, 0, repeat, status, **{**defaults, **known})


def test_median_and_range_of_the_repeats():
    (cell,) = gather_cells([record(i, runtime_s=t) for i, t in enumerate((3.0, 1.0, 7.0))])
    assert cell.values["runtime_s"] == Interval(3.0, 1.0, 7.0, 3)


def test_a_failed_repeat_is_counted_and_does_not_enter_the_median():
    (cell,) = gather_cells([record(0, runtime_s=1.0), record(1, "failed"), record(2, runtime_s=3.0)])
    assert cell.values["runtime_s"].n == 2
    assert cell.status == "2 ok, 1 failed"
    assert cell.message == "why"


def test_a_metric_that_is_not_defined_is_absent():
    (cell,) = gather_cells([record(metrics={"a": math.nan, "b": 1.0})])
    assert "a" not in cell.values
    assert cell.value("b") == 1.0


def test_settings_and_damage_to_the_input_are_cells_of_their_own():
    rows = [record(), record(variant="f k=2"), record(perturbation="noise", perturbation_level=0.5)]
    assert [(c.model, c.method) for c in gather_cells(rows)] == [
        ("m", "f"),
        ("m", "f k=2"),
        ("m + noise 0.5", "f"),
    ]


def cell(cost, error):
    values = {"t": Interval.of([cost]), "e": Interval.of([error])}
    return Cell("m", f"{cost} {error}", 0.9, 100, 10, {"ok": 1}, values=values)


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=30))
def test_no_cell_beats_one_of_the_front_and_each_other_is_matched_by_one(pairs):
    cells = [cell(*pair) for pair in pairs]
    front = pareto_front(cells, "t", "e")
    assert front
    for other in cells:
        cost, error = other.value("t"), other.value("e")
        assert not any(cost <= f.value("t") and error < f.value("e") for f in front)
        assert any(f.value("t") <= cost and f.value("e") <= error for f in front)
