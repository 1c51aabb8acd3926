"""What the command does while the process starts that the cases are forked from."""

from lpcompare.benchmark.runner import load_models, run_plan
from lpcompare.benchmark.study import build_plan


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
