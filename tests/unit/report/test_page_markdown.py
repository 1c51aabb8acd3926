"""The Markdown page of a run: ratios against a reference by hand, failures listed, names escaped."""

from lpcompare.benchmark.record import Record, Run
from lpcompare.report.page_markdown import write_study_page

STARTED = "2026-01-02T03:04:05"
FACTS = {"command": "lpcompare run", "started": STARTED, "commit": "", "cpu": "a chip", "cores": 2}


def record(method, model, error, status="ok", message=""):
    metrics = {"plane_error_pct": error} if status == "ok" else {}
    return Record(
        model,
        method,
        0.8,
        100,
        20,
        0,
        0,
        status,
        message,
        n_output=20,
        runtime_s=0.5,
        variant=method,
        metrics=metrics,
    )


def page(tmp_path, records):
    run = Run(tmp_path, {}, FACTS | {"python": "3"}, {}, tuple(records), True)
    return write_study_page(run, tmp_path / "README.md").read_text(encoding="utf-8")


def test_ratios_are_geometric_means_over_the_reference(tmp_path):
    text = page(
        tmp_path,
        [
            record("poisson_disk", "a", 1.0),
            record("poisson_disk", "b", 4.0),
            record("lp_uniform", "a", 0.5),
            record("lp_uniform", "b", 1.0),
        ],
    )
    assert "| lp\\_uniform | 0.35 |" in text
    assert "| lp\\_uniform | 0.50 | 0.25 | 500 ms |" in text


def test_a_method_that_failed_is_named_with_its_reason(tmp_path):
    rows = [record("poisson_disk", "a", 1.0), record("shaky", "a", 0.0, "failed", "It <b>broke</b>.")]
    text = page(tmp_path, rows)
    assert "shaky on a, 80 %: failed. It \\<b\\>broke\\</b\\>." in text
    assert "| shaky | - |" in text


def test_a_case_that_is_missing_lowers_the_count_in_brackets(tmp_path):
    rows = [record(m, s, 1.0) for m, s in (("poisson_disk", "a"), ("poisson_disk", "b"), ("voxel", "a"))]
    assert "| voxel | 1.00 (1) |" in page(tmp_path, rows)


def test_an_empty_run_is_a_page(tmp_path):
    assert "nothing was compared" in page(tmp_path, [])
