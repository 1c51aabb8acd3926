"""What the command does while the process starts that the cases are forked from."""

import signal
from types import SimpleNamespace

import pytest

from lpcompare.benchmark.case import Request, run_case
from lpcompare.benchmark.record import Record
from lpcompare.benchmark.runner import load_models, run_plan
from lpcompare.benchmark.study import build_plan
from lpcompare.processes.children import Ending


def test_work_is_done_meanwhile_before_the_first_case_and_only_if_there_is_one(tmp_path):
    told = []
    plan = build_plan({"models": ["cube"], "methods": ["random_sample"], "reductions": [0.9]})
    models = load_models(plan.models)

    def run(**more):
        told.clear()
        run_plan(
            plan,
            models,
            tmp_path,
            listener=lambda case, record, **_: told.append(case.variant.method),
            meanwhile=lambda: told.append("meanwhile"),
            **more,
        )
        return told

    assert run() == ["meanwhile", "random_sample", "random_sample"]
    assert run(resume=True) == ["random_sample", "random_sample"]


@pytest.mark.parametrize(
    ("ending", "again"),
    [
        (Ending(None, "guard", "", ""), True),
        (Ending(-signal.SIGKILL, "", "", ""), True),
        (Ending(-signal.SIGTERM, "", "", ""), True),
        (Ending(-signal.SIGSEGV, "", "", ""), False),
        (Ending(None, "time", "", ""), False),
        (Ending(None, "memory", "", ""), False),
        (Ending(3, "", "", ""), False),
    ],
)
def test_only_a_case_that_was_killed_from_outside_is_run_again(ending, again, tmp_path):
    blank = Record("cube", "random_sample", 0.9, 100, 10, 0, 0, "failed", key="k")
    children = SimpleNamespace(call=lambda *_, **__: ending)
    limits = {"time_limit_s": 1.0, "memory_limit_mib": 1, "threads": 1}
    record = run_case(children, Request(blank, "", "", "", {}, 0), tmp_path, **limits).record
    assert (record.key == "") == again
    assert record.status in ("failed", "timeout")
