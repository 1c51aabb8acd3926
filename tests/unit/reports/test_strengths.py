"""What each method of the study is good at: places, sentences, failures."""

import runpy
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.report.frames import record, run_of

STRENGTHS = runpy.run_path(str(Path(__file__).resolve().parents[3] / "reports" / "methods" / "strengths.py"))
METHODS = ("lp_uniform", "poisson_disk", "random_sample")


def study_of(errors, *more):
    """A study of three methods: error by method, the same by the largest distance."""
    rows = [
        record(method, model=model, error=error, metrics={"hausdorff_pct": error})
        for model in "abc"
        for method, error in zip(METHODS, errors, strict=True)
    ]
    return STRENGTHS["Study"](run_of([*rows, *more]))


def text(part, found):
    return "\n".join(STRENGTHS[part](found))


@settings(max_examples=8, deadline=None)
@given(st.permutations([1.0, 2.0, 3.0]), st.floats(0.1, 5.0))
def test_places_follow_the_order_alone(errors, power):
    plain, bent = (study_of(values).places for values in (errors, [e**power for e in errors]))
    assert (plain == bent).all(axis=None)
    assert [plain.at[m, "all"] for m in METHODS] == errors


def test_a_result_with_another_count_takes_no_part():
    more = [record("voxel_nearest", model=m, n_output=5, error=0.1) for m in "abc"]
    found = study_of([1.0, 2.0, 3.0], *more)
    assert "voxel_nearest" not in found.places.index
    assert "Of its 3 cases, 3 gave another count" in text("paragraphs", found)


def test_a_case_with_fewer_methods_weighs_as_much():
    """A method that is last of two in its only case is not better off than one that is last of three."""
    found = study_of([1.0, 2.0, 3.0])
    assert found.shares.loc["random_sample"].eq(1).all()
    fewer = STRENGTHS["Study"](run_of([record("a", error=1.0), record("b", error=2.0)]))
    assert fewer.shares.loc["b"].eq(1).all()


def test_the_paragraph_says_first_worst_seconds_and_failures():
    more = record("lp_uniform", model="d", status="timeout")
    told = next(
        line for line in STRENGTHS["paragraphs"](study_of([1.0, 2.0, 3.0], more)) if "lp_uniform" in line
    )
    assert "It is first by plane error and Hausdorff distance." in told
    assert "Its plane error is 0.50 and its Hausdorff distance 0.50 times" in told
    assert "A call takes 1.00 s in the median" in told
    assert "Of its 4 cases, 1 ran out of time." in told


@pytest.mark.parametrize(
    ("errors", "says"), [([1.0, 2.0, 3.0], ""), ([3.0, 2.0, 1.0], "not among the first")]
)
def test_what_the_default_loses_is_said_first(errors, says, monkeypatch):
    monkeypatch.setitem(STRENGTHS["winners"].__globals__, "LOST", 2)
    first = next(iter(STRENGTHS["winners"](study_of(errors))))
    assert bool(first) == bool(says)
    assert says in first


def test_failures_are_rows():
    found = study_of([1.0, 2.0, 3.0], record("cgal_wlop", model="a", status="timeout"))
    assert "| `cgal_wlop` | ran out of time | 1 | a | why |" in text("failures", found)
    assert text("failures", study_of([1.0, 2.0, 3.0])) == "Every case has a result."


def test_a_call_that_is_too_slow_is_named():
    facts = {"model": "stanford-bunny", "foreign_load": 0.0, "peak_memory_mib": 300.0}
    runs = [record(m, runtime_s=s, cpu_s=c, **facts) for m, s, c in (("a", 12.0, 4.0), ("b", 15.0, 11.0))]
    told = text("speed", STRENGTHS["Study"](run_of(runs)))
    assert (
        "By processor time, one method took longer (`b`); by the clock, two methods took longer (`a` and `b`)."
        in told
    )
    assert "300 MiB (`a`)" in told
