"""Two runs side by side: pairs, refusals, verdicts."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.benchmark.record import Record, Run
from lpcompare.errors import InputError
from lpcompare.report.comparison import (
    LEVEL,
    compare_methods,
    compare_runs,
    differing_environment,
    format_comparison,
    format_methods,
    holm_levels,
    paired_differences,
)
from lpcompare.report.tables import NARROW


def run_of(rng, *, slower=1.0, worse=0.0, busy=1.0, noise=0.05, sha="same", reductions=(0.7, 0.8, 0.9)):
    """A made-up run, 5 repeats; ``busy`` slows the machine, ``slower`` and ``worse`` one of two methods."""
    records = []
    for method, factor, added in (("poisson_disk", 1.0, 0.0), ("ours", slower, worse)):
        for reduction in reductions:
            for repeat in range(5):
                seconds = 0.1 * factor * busy * math.exp(rng.normal(0, noise))
                reference = 0.01 * busy * math.exp(rng.normal(0, noise))
                error = 0.1 / (1 - reduction) + added * (1 + 0.1 * rng.random())
                records.append(
                    Record(
                        "ball",
                        method,
                        reduction,
                        100,
                        20,
                        0,
                        repeat,
                        "ok",
                        variant=method,
                        runtime_s=seconds,
                        cpu_s=seconds,
                        reference_s=reference,
                        reference_cpu_s=reference,
                        foreign_load=0.01,
                        points_sha256="x",
                        metrics={"plane_error_pct": error},
                    )
                )
    environment = {"cpu": "a", "packages": {"numpy": "2"}, "threads": {"OMP_NUM_THREADS": "1"}}
    return Run(Path("run"), {"jobs": 1}, environment, {"ball": {"sha256": sha}}, tuple(records), True)


def verdicts(first, second):
    """The rows of a comparison, poisson_disk first."""
    return list(compare_runs(first, second).itertuples())


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_the_same_program_twice_is_called_different_at_most_at_the_level(rng):
    alarms = 0
    for _ in range(60):
        rows = verdicts(run_of(rng), run_of(rng))
        alarms += any(row.runtime != "n.s." for row in rows)
        assert all(row.quality == "identical" for row in rows)
    assert alarms <= 0.05 * 60


def test_a_busy_machine_is_not_a_slower_method(rng):
    rows = verdicts(run_of(rng), run_of(rng, busy=2.0))
    assert all(row.runtime == "n.s." for row in rows)


def test_a_wall_clock_disturbed_by_other_programs_is_not_judged(rng):
    """A call too short to be interrupted looks fast beside reference work that was interrupted."""
    disturbed = run_of(rng)
    waited = tuple(replace(r, reference_s=3 * r.reference_s) for r in disturbed.records)
    rows = verdicts(run_of(rng), replace(disturbed, records=waited))
    assert all(row.runtime == "busy" for row in rows)
    assert all(row.wall < -0.9 for row in rows), "the ratio itself is shown"


@pytest.mark.parametrize(("load", "judged"), [(0.05, "slower"), (0.5, "busy")])
def test_runtimes_beside_other_programs_are_not_judged(rng, load, judged):
    slower = run_of(rng, slower=1.3)
    slower = replace(slower, records=tuple(replace(r, foreign_load=load) for r in slower.records))
    assert verdicts(run_of(rng), slower)[1].runtime == judged
    assert ("busy in one of the runs" in format_comparison(run_of(rng), slower)) == (judged == "busy")


def test_calls_too_short_to_judge_are_not_judged(rng):
    def short(run):
        return replace(run, records=tuple(replace(r, runtime_s=r.runtime_s / 1000) for r in run.records))

    rows = verdicts(short(run_of(rng)), short(run_of(rng, slower=2.0)))
    assert [row.runtime for row in rows] == ["too short", "too short"]


def test_a_fifth_slower_is_found_and_the_other_method_is_not_blamed(rng):
    other, ours = verdicts(run_of(rng), run_of(rng, slower=1.2))
    assert ours.runtime == "slower"
    assert other.runtime == "n.s."
    assert math.exp(ours.wall) == pytest.approx(1.2, rel=0.06)
    assert verdicts(run_of(rng, slower=1.2), run_of(rng))[1].runtime == "faster"


def test_worse_errors_are_found(rng):
    other, ours = verdicts(run_of(rng), run_of(rng, worse=0.01))
    assert ours.quality == "worse"
    assert ours.error == pytest.approx(0.0105, rel=0.05)
    assert other.quality == "identical"


def test_different_inputs_are_refused(rng):
    with pytest.raises(InputError, match="ball is not the same cloud"):
        compare_runs(run_of(rng), run_of(rng, sha="other"))
    bare = replace(run_of(rng), inputs={"cube": {"sha256": "same"}})
    with pytest.raises(InputError, match="share no input"):
        compare_runs(run_of(rng), bare)
    with pytest.raises(InputError, match="no finished case in common"):
        compare_runs(run_of(rng), run_of(rng, reductions=(0.5,)))


def test_runs_without_reference_work_are_compared_in_seconds(rng):
    def bare(run):
        return replace(run, records=tuple(replace(r, reference_s=None, cpu_s=None) for r in run.records))

    rows = verdicts(bare(run_of(rng)), bare(run_of(rng, slower=1.5)))
    assert [row.runtime for row in rows] == ["n.s.", "slower"]
    assert math.isnan(rows[0].cpu)


def test_what_else_is_different_is_named(rng):
    other = replace(run_of(rng), environment={"cpu": "b", "packages": {"numpy": "3"}, "threads": {}})
    changes = differing_environment(run_of(rng), other)
    assert changes == {"cpu": ("a", "b"), "numpy": ("2", "3"), "OMP_NUM_THREADS": ("1", "-")}


def test_methods_of_one_run_are_paired_over_cases(rng):
    (row,) = compare_methods(run_of(rng, slower=2.0, worse=0.05)).itertuples()
    assert row.Index == "ours"
    assert row.error_n == 3
    assert row.runtime == "slower"
    only_ours = tuple(r for r in run_of(rng).records if r.method == "ours")
    assert compare_methods(replace(run_of(rng), records=only_ours)).empty


def test_tables_fit_the_page(rng):
    texts = [
        format_comparison(run_of(rng), run_of(rng, slower=1.3, worse=0.1)),
        format_methods(run_of(rng, worse=0.02)),
    ]
    for text in texts:
        assert "ours" in text
        assert max(map(len, text.splitlines())) <= NARROW
    json.dumps(texts)


def holm(p_values):
    """The adjusted p-values of Holm's method, written down from its definition."""
    order = np.argsort(p_values, kind="stable")
    adjusted = np.empty(len(order))
    adjusted[order] = np.maximum.accumulate(np.asarray(p_values)[order] * np.arange(len(order), 0, -1))
    return np.minimum(1, adjusted)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_a_p_value_is_below_its_level_where_its_adjusted_value_is_below_five_percent(p_values):
    assert np.array_equal(np.asarray(p_values) < holm_levels(p_values), holm(p_values) < LEVEL)


def test_levels_of_a_worked_example():
    assert holm_levels([0.01, 0.04, 0.03]) == pytest.approx([0.05 / 3, 0.025, 0.025])


@settings(deadline=None)
@given(
    st.lists(st.lists(st.floats(-1, 1), min_size=2, max_size=6), min_size=1, max_size=6), st.floats(0, 0.2)
)
def test_the_interval_and_the_verdict_say_the_same(groups, margin):
    table = paired_differences({str(i): g for i, g in enumerate(groups)}, margin)
    beyond = np.where(table.low > margin, 1, np.where(table.high < -margin, -1, 0))
    assert np.array_equal(table.sign, beyond)
    assert (table.low <= table["mean"]).all()
    assert (table["mean"] <= table.high).all()


def test_false_alarms_stay_at_the_level_and_a_fifth_more_is_found():
    rng = np.random.default_rng(1)
    margin = math.log(1.05)

    def calls(true_ratio):
        draws = rng.normal(math.log(true_ratio), 0.08, size=(400, 12))
        return np.mean([paired_differences({"a": d}, margin).sign["a"] != 0 for d in draws])

    assert calls(1.0) <= LEVEL
    assert calls(1.05) <= LEVEL + 0.03
    assert calls(1.2) > 0.95


def test_all_calls_of_many_methods_together_hold_the_level():
    draws = np.random.default_rng(2).normal(size=(300, 8, 8))
    alarms = [paired_differences(dict(enumerate(runs))).sign.ne(0).any() for runs in draws]
    assert np.mean(alarms) == pytest.approx(LEVEL, abs=0.03)


def test_equal_pairs_are_no_difference_and_constant_ones_are():
    found = paired_differences({"equal": [0.0] * 5, "constant": [0.3] * 5, "little": [0.03] * 5}, margin=0.05)
    assert found.sign.to_list() == [0, 1, 0]
    assert paired_differences({"a": [0.03] * 5}).sign["a"] == 1


def test_one_pair_says_nothing():
    (row,) = paired_differences({"a": [3.0]}).itertuples()
    assert (row.n, row.mean, row.sign) == (1, 3.0, 0)
    assert row.high == math.inf


def test_escapes_of_a_terminal_do_not_reach_it(rng):
    odd = replace(run_of(rng), environment={"cpu": "\x1b[31mred\x1b[0m\nchip"})
    assert "cpu: a -> red chip" in format_comparison(run_of(rng), odd)
