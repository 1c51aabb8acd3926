"""Two runs side by side: pairs, refusals, verdicts."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lpcompare.benchmark.record import Record, Run
from lpcompare.errors import InputError
from lpcompare.report.comparison import compare_runs, differing_environment
from lpcompare.report.comparison_table import format_comparison, format_methods
from lpcompare.report.within import compare_methods


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


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_the_same_program_twice_is_called_different_at_most_at_the_level(rng):
    alarms = 0
    for _ in range(60):
        rows = compare_runs(run_of(rng), run_of(rng))
        alarms += any(row.runtime_verdict != "n.s." for row in rows)
        assert all(row.error_verdict == "identical" for row in rows)
    assert alarms <= 0.05 * 60


def test_a_busy_machine_is_not_a_slower_method(rng):
    rows = compare_runs(run_of(rng), run_of(rng, busy=2.0))
    assert all(row.runtime_verdict == "n.s." for row in rows)


def test_a_wall_clock_disturbed_by_other_programs_is_not_judged(rng):
    """A call too short to be interrupted looks fast beside reference work that was interrupted."""
    disturbed = run_of(rng)
    waited = tuple(replace(r, reference_s=3 * r.reference_s) for r in disturbed.records)
    rows = compare_runs(run_of(rng), replace(disturbed, records=waited))
    assert all(row.runtime_verdict == "busy" for row in rows)
    assert all(row.wall.mean < -0.9 for row in rows), "the ratio itself is shown"


@pytest.mark.parametrize(("load", "judged"), [(0.05, "slower"), (0.5, "busy")])
def test_runtimes_beside_other_programs_are_not_judged(rng, load, judged):
    slower = run_of(rng, slower=1.3)
    slower = replace(slower, records=tuple(replace(r, foreign_load=load) for r in slower.records))
    assert compare_runs(run_of(rng), slower)[1].runtime_verdict == judged
    assert ("busy in one of the runs" in format_comparison(run_of(rng), slower)) == (judged == "busy")


def test_calls_too_short_to_judge_are_not_judged(rng):
    def short(run):
        return replace(run, records=tuple(replace(r, runtime_s=r.runtime_s / 1000) for r in run.records))

    rows = compare_runs(short(run_of(rng)), short(run_of(rng, slower=2.0)))
    assert [row.runtime_verdict for row in rows] == ["too short", "too short"]


def test_a_fifth_slower_is_found_and_the_other_method_is_not_blamed(rng):
    other, ours = compare_runs(run_of(rng), run_of(rng, slower=1.2))
    assert ours.runtime_verdict == "slower"
    assert other.runtime_verdict == "n.s."
    assert math.exp(ours.wall.mean) == pytest.approx(1.2, rel=0.06)
    assert compare_runs(run_of(rng, slower=1.2), run_of(rng))[1].runtime_verdict == "faster"


def test_worse_errors_are_found(rng):
    other, ours = compare_runs(run_of(rng), run_of(rng, worse=0.01))
    assert ours.error_verdict == "worse"
    assert ours.error.mean == pytest.approx(0.0105, rel=0.05)
    assert other.error_verdict == "identical"


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

    rows = compare_runs(bare(run_of(rng)), bare(run_of(rng, slower=1.5)))
    assert [row.runtime_verdict for row in rows] == ["n.s.", "slower"]
    assert rows[0].cpu is None


def test_what_else_is_different_is_named(rng):
    other = replace(run_of(rng), environment={"cpu": "b", "packages": {"numpy": "3"}, "threads": {}})
    changes = differing_environment(run_of(rng), other)
    assert changes == {"cpu": ("a", "b"), "numpy": ("2", "3"), "OMP_NUM_THREADS": ("1", "-")}


def test_methods_of_one_run_are_paired_over_cases(rng):
    (row,) = compare_methods(run_of(rng, slower=2.0, worse=0.05).records)
    assert row.variant == "ours"
    assert row.error.n == 3
    assert row.runtime_verdict == "slower"
    assert compare_methods([r for r in run_of(rng).records if r.method == "ours"]) == []


def test_tables_fit_the_page(rng):
    texts = [
        format_comparison(run_of(rng), run_of(rng, slower=1.3, worse=0.1)),
        format_methods(run_of(rng, worse=0.02)),
    ]
    for text in texts:
        assert "ours" in text
        assert max(map(len, text.splitlines())) <= 100
    json.dumps(texts)
