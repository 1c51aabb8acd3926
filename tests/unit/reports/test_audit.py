"""Verdicts follow the numbers: each statement with tables that support it and tables that do not."""

import pytest
from reports.paper import audit


def errors(slope):
    return [
        {
            "model": "m", "reading": "lp_density", "retention": "exact-count", "reduction": rate,
            "n_clusters": str(k), "seed": str(seed), "plane_error_k8_pct": str(float(rate) * (1 + slope * k)),
        }
        for rate in ("0.7", "0.8", "0.9") for k in (10, 20, 30) for seed in range(3)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("slope", "verdict"), [(-0.01, "confirmed"), (0.01, "not confirmed"), (0, "not confirmed")]
)
def test_more_clusters_follow_the_slope(slope, verdict):
    assert audit.more_clusters({"errors": errors(slope)}, "m").verdict == verdict


def test_the_error_must_grow_with_every_rate():
    rows = errors(0)
    assert audit.higher_rate({"errors": rows}, "m").verdict == "confirmed"
    rows[-1]["plane_error_k8_pct"] = "0.1"
    assert audit.higher_rate({"errors": rows}, "m").verdict == "not confirmed"


@pytest.mark.parametrize(
    ("count", "verdict"), [(20130, "confirmed"), (20331, "confirmed"), (20340, "not confirmed")]
)
def test_the_papers_count_is_confirmed_within_one_per_cent(count, verdict):
    rows = [{"model": "stanford-bunny", "n_clusters": "20", "seed": "0", "n_output": str(count)}]
    assert audit.count_with_features({"counts": rows}, "stanford-bunny").verdict == verdict


@pytest.mark.parametrize(("grown", "verdict"), [(2.0, "confirmed"), (9.0, "refuted")])
def test_robust_means_losing_less_than_a_random_choice(grown, verdict):
    rows = [
        {"model": "m", "method": method, "kind": kind, "level": level, "plane_error_k8_pct": str(error)}
        for method, last in (("lp_printed", grown), ("lp_density", grown), ("random_sample", 3.0))
        for kind, level, error in (("none", "0", 1.0), ("noise", "1", last), ("outliers", "0.05", last))
    ]
    assert audit.robustness({"robustness": rows}, "m").verdict == verdict


@pytest.mark.parametrize(
    ("errors_by_share", "verdict"),
    [
        ({0.0: 3, 0.5: 2, 1.0: 1}, "confirmed"),
        ({0.0: 2, 0.5: 1, 1.0: 3}, "not confirmed"),
        ({0.0: 1, 0.5: 2, 1.0: 3}, "refuted"),
    ],
)
def test_the_feature_rule_is_held_against_none_and_some(errors_by_share, verdict):
    rows = [
        {"model": "m", "reduction": "0.9", "feature_share": f"{share:g}", "plane_error_k8_pct": str(error)}
        for share, error in errors_by_share.items()
    ]
    assert audit.feature_rule({"features": rows}, "m").verdict == verdict


def test_a_model_that_is_not_in_the_tables_has_no_findings():
    names = ("program", "counts", "errors", "features", "holes", "robustness", "seconds")
    tables = {name: [] for name in names}
    assert audit.audit(tables, "stanford-bunny") == []
