"""The time that is left: from the start of a process at first, then from what the finished cases took."""

import pytest

from lpcompare.benchmark.plan import Plan, Variant
from lpcompare.benchmark.record import Record
from lpcompare.cli import _progress
from lpcompare.cli._progress import Estimate, RunProgress, duration, start_seconds

PLAN = Plan(("small", "large"), (Variant("quick"), Variant("slow")), reductions=(0.8,), repeats=5)
SIZES = {"small": 1000, "large": 100_000}


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands still until it is told to go on."""
    now = [0.0]
    monkeypatch.setattr(_progress, "monotonic", lambda: now[0])

    def go_on(seconds):
        now[0] += seconds

    return go_on


def record_of(case):
    return Record(case.model, case.variant.method, case.reduction, 10, 2, case.seed, case.repeat, "ok")


def guess(cases, jobs=1):
    return Estimate(SIZES, jobs, 0.3).remaining_s(cases)


def test_the_first_guess_is_as_long_as_the_machine_is_slow_and_a_cloud_is_large():
    cases = list(PLAN.cases())
    assert Estimate(SIZES, 1, 3.0).remaining_s(cases) == pytest.approx(10 * guess(cases))
    assert guess(cases, jobs=2) == pytest.approx(guess(cases) / 2)
    small, large = ([c for c in cases if c.model == model] for model in SIZES)
    assert guess(large) > 3 * guess(small)
    assert 0.05 < start_seconds() < 60


def test_what_is_left_scales_by_what_the_finished_cases_took_over_what_was_expected(clock):
    cases = list(PLAN.cases())
    estimate = Estimate(SIZES, 1, 0.3)
    with RunProgress(cases, estimate) as progress:
        for case in cases[:4]:
            progress(case, None)
            clock(guess([case]) * {"quick": 2, "slow": 10}[case.variant.method])
            progress(case, record_of(case))
    left = {name: [c for c in cases[4:] if c.variant.method == name] for name in ("quick", "slow")}
    assert estimate.remaining_s(left["quick"]) == pytest.approx(2 * guess(left["quick"]))
    assert estimate.remaining_s(left["slow"]) == pytest.approx(10 * guess(left["slow"]))
    unseen = list(Plan(("large",), (Variant("new"),)).cases())
    assert estimate.remaining_s(unseen) == pytest.approx(6 * guess(unseen))


def test_cases_taken_over_from_an_earlier_start_teach_nothing(clock):
    cases = list(PLAN.cases())
    estimate = Estimate(SIZES, 1, 0.3)
    with RunProgress(cases, estimate) as progress:
        progress(cases[0], None)
        clock(0.001)
        progress(cases[0], record_of(cases[0]), reused=True)
    assert estimate.remaining_s(cases[1:]) == pytest.approx(guess(cases[1:]))


def test_durations_are_for_people():
    assert [duration(s) for s in (0.2, 40, 200, 4800, 7260)] == [
        "1 s",
        "40 s",
        "3 min",
        "80 min",
        "2 h 1 min",
    ]
