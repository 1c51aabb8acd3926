"""Plans, studies and settings: counts, order, and what is refused before anything runs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare.benchmark.perturbation import CLEAN
from lpcompare.benchmark.plan import Plan, Variant
from lpcompare.benchmark.study import (
    build_plan,
    choose_methods,
    choose_metrics,
    perturbations,
    preset_names,
    read_study,
    variants,
)
from lpcompare.checks import target_from_reduction as target_count
from lpcompare.cli._settings import parse_assignments
from lpcompare.errors import InputError, UnknownName
from lpcompare.registry import METHODS, METRICS

MACHINE = {"memory_limit_mib": 1024, "threads": 1, "jobs": 1}


@pytest.mark.parametrize(
    ("n", "reduction", "count"),
    [(35947, 0.7, 10784), (35947, 0.8, 7189), (35947, 0.9, 3594), (10, 0.9, 1), (10, 0.7, 3), (3, 0.99, 1)],
)
def test_target_count_is_the_papers_floor(n, reduction, count):
    assert target_count(n, reduction) == count


@given(n=st.integers(1, 10**7), tenths=st.integers(0, 9))
def test_target_count_is_exact_at_tenths(n, tenths):
    assert target_count(n, tenths / 10) == max(1, (10 - tenths) * n // 10)


def test_cases_go_round_robin_over_the_methods():
    plan = Plan(("a", "b"), (Variant("x"), Variant("y")), (0.5, 0.9), seeds=(0, 1), repeats=2)
    cases = list(plan.cases())
    assert len(cases) == len(plan) == len(set(cases)) == 32
    assert [c.variant.method for c in cases[:4]] == ["x", "y", "x", "y"]
    assert [c.repeat for c in cases] == sorted(c.repeat for c in cases)


def test_as_printed_runs_the_papers_method_first():
    plan = Plan(("a",), (Variant("x"), Variant("lp_printed")), (0.5,), protocol="as-printed")
    assert [c.variant.method for c in plan.cases()] == ["lp_printed", "x"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"reductions": (1.5,)}, "reduction is 1.5"),
        ({"reductions": (-0.1,)}, "reduction is -0.1"),
        ({"reductions": (float("nan"),)}, "reduction is nan"),
        ({"reductions": (0.5, 0.5)}, "reductions twice"),
        ({"models": ()}, "no models"),
        ({"repeats": 0}, "repeats is 0"),
        ({"jobs": -1}, "jobs is -1"),
        ({"threads": 0}, "threads is 0"),
        ({"seeds": (-1,)}, "seed is -1"),
        ({"seeds": (2**63,)}, "seed is 9223372036854775808"),
        ({"time_limit_s": 0.0}, "time limit in seconds is 0"),
        ({"time_limit_s": float("inf")}, "time limit in seconds is inf"),
        ({"time_limit_s": float("nan")}, "time limit in seconds is nan"),
        ({"time_limit_s": 1e300}, "time limit in seconds is 1e[+]300"),
        ({"memory_limit_mib": 5}, "memory limit in MiB is 5"),
        ({"repeats": 2_000_000}, "6,000,000 cases"),
        ({"protocol": "as-printed"}, "takes its counts from lp_printed"),
    ],
)
def test_an_impossible_plan_is_refused_in_a_sentence(change, words):
    fields = {"models": ("a",), "variants": (Variant("x"),)} | change
    with pytest.raises(InputError, match=words):
        Plan(**fields).check()


def test_an_unknown_protocol_is_refused():
    with pytest.raises(UnknownName, match="equal-count"):
        Plan(("a",), (Variant("x"),), protocol="fair").check()


def test_the_default_methods_need_no_extra_and_all_are_those_installed(monkeypatch):
    assert len(choose_methods(None)) == 17
    assert not any(METHODS.traits(name).extra for name in choose_methods(()))
    assert choose_methods(["all"]) == tuple(name for name in METHODS if not METHODS.missing(name))
    assert choose_methods(["lp_density"]) == ("lp_density",)


def test_slow_metrics_run_only_when_asked_for():
    slow = {name for name in METRICS if getattr(METRICS.module(name), "COST", "") == "slow"}
    assert not slow & set(choose_metrics(()))
    assert set(choose_metrics(("all",))) == set(METRICS.names())
    assert all(name in choose_metrics((name,)) for name in slow)
    with pytest.raises(UnknownName):
        choose_metrics(("beauty",))


def test_settings_are_read_as_toml_and_checked_against_the_signature():
    assert parse_assignments(["lp_density.n_clusters=25"], ["lp_density"]) == {
        "lp_density": {"n_clusters": 25}
    }
    words = ["lp_density.retention=exact-count", "lp_density.gap=1"]
    assert parse_assignments(words, ["lp_density"])["lp_density"] == {"retention": "exact-count", "gap": 1}


@pytest.mark.parametrize(
    ("word", "error", "words"),
    [
        ("nonsense", InputError, "method.setting=value"),
        ("lp_density.n_clusters", InputError, "method.setting=value"),
        ("nosuch.k=1", UnknownName, "Unknown method 'nosuch'"),
        ("lp_printed.n_clusters=3", InputError, "not part of this run"),
        ("lp_density.n_cluster=3", UnknownName, "n_clusters"),
        ("lp_density.n_clusters=many", InputError, "n_clusters is 'many'"),
        ("lp_density.n_clusters=2.5", InputError, "Expected `int"),
        ("lp_density.n_clusters=true", InputError, "Expected `int"),
    ],
)
def test_a_wrong_assignment_is_refused_in_a_sentence(word, error, words):
    with pytest.raises(error, match=words):
        parse_assignments([word], ["lp_density"])


def test_a_method_without_settings_says_so():
    with pytest.raises(UnknownName, match="setting of random_sample"):
        METHODS.check_settings("random_sample", {"k": 1})


def test_a_list_of_values_is_a_grid():
    grid = variants(["lp_density"], {"lp_density": {"n_clusters": [5, 10], "retention": "exact-count"}})
    assert [v.settings["n_clusters"] for v in grid] == [5, 10]
    assert grid[0].label == "lp_density n_clusters=5 retention=exact-count"


def test_damage_stands_beside_the_clean_cloud():
    assert [p.label for p in perturbations({"noise": [0, 0.5], "missing": [0.1]})] == [
        "",
        "noise 0.5",
        "missing 0.1",
    ]
    assert perturbations({}) == (CLEAN,)


@pytest.mark.parametrize("name", preset_names())
def test_every_preset_is_a_plan(name):
    study = read_study(name)
    assert study["title"].endswith((".", "?"))
    plan = build_plan(study, **MACHINE)
    assert plan.title == study["title"]
    assert len(plan) == len(list(plan.cases())) > 0


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("models = ['a'", InputError, "cannot be read"),
        ("modles = ['a']", UnknownName, "models"),
        ("models = 'a'", InputError, "models"),
        ("repeats = '3'", InputError, "repeats"),
        ("settings = {lp_density = 3}", InputError, "settings"),
        ("perturbations = {noise = ['a']}", InputError, "perturbations"),
        ("perturbations = {noise = [true]}", InputError, "perturbations"),
        ("a=" + "[" * 100_000, InputError, "cannot be read"),
        ("#" * 2_000_000, InputError, "larger than 1 MiB"),
    ],
)
def test_a_broken_study_is_refused_in_a_sentence(tmp_path, text, error, words):
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(error, match=words):
        read_study(str(tmp_path / "study.toml"))


def test_an_unknown_study_names_the_presets():
    with pytest.raises(UnknownName, match="robustness"):
        read_study("robust")


def test_all_processors_are_shared_by_the_jobs():
    plan = build_plan({"models": ["a"]}, memory_limit_mib=None, threads=None, jobs=2)
    alone = build_plan({"models": ["a"]}, memory_limit_mib=None, threads=None, jobs=1)
    assert plan.threads == max(1, alone.threads // 2)
    assert plan.memory_limit_mib <= alone.memory_limit_mib
    assert np.isclose(alone.memory_limit_mib, 2 * plan.memory_limit_mib, rtol=0.01)


def test_a_study_in_another_encoding_is_refused_without_the_words_of_a_library(tmp_path):
    (tmp_path / "a.toml").write_text('title = "Brücke"\n', encoding="utf-16")
    with pytest.raises(InputError, match="it is no text in UTF-8"):
        read_study(str(tmp_path / "a.toml"))
