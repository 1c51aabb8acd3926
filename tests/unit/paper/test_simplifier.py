"""The whole filter: what it reports, what it refuses, and its laws."""

import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone

import lpcompare
from lpcompare.errors import InputError, UnknownName
from lpcompare.estimators import LPSimplifier

simplify = partial(lpcompare.simplify, method="lp_density")


def bumpy(n_points, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n_points, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * (1 + 0.1 * np.sin(7 * points[:, :1]) * np.cos(5 * points[:, 1:2]))


def turn(seed):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


@pytest.fixture(scope="module")
def fitted():
    return LPSimplifier(target_reduction=0.8, n_clusters=6).fit(bumpy(1500))


def test_reports_what_a_study_wants_to_see(fitted):
    assert fitted.labels_.shape == (1500,)
    assert fitted.feature_mask_.dtype == bool
    assert fitted.sample_indices_.shape == (300,)
    assert fitted.mixture_.means.shape == (6, 3)
    assert (np.diff(fitted.mixture_.log_likelihoods) > 0).all()
    assert fitted.responsibilities(bumpy(1500)).argmax(axis=1).tolist() == fitted.labels_.tolist()
    assert list(fitted.timings_) == ["clustering", "curvature", "selection"]
    assert len(fitted.certificates_) == 6
    assert sum(c.n_candidates for c in fitted.certificates_) <= 1500


def test_densities_are_in_model_units():
    points = bumpy(800)
    small = LPSimplifier(target_reduction=0.8, n_clusters=3).fit(points)
    large = LPSimplifier(target_reduction=0.8, n_clusters=3).fit(points * 8)
    for a, b in zip(small.certificates_, large.certificates_, strict=True):
        assert b.density == pytest.approx(a.density / 8)
        assert b.objective == pytest.approx(a.objective / 8, abs=1e-12)
    rows = small.labels_ == 0
    certificate = small.certificates_[0]
    distances = np.linalg.norm(points[rows] - points[rows].mean(axis=0), axis=1)
    assert (1 / distances).min() < certificate.density < (1 / distances).max()


def test_mixture_and_curvature_are_in_model_units():
    points = bumpy(800) * 50 + [1000.0, 0, -300]
    fitted = LPSimplifier(target_reduction=0.5, n_clusters=1).fit(points)
    assert fitted.mixture_.means[0] == pytest.approx(points.mean(axis=0))
    assert fitted.mixture_.covariances[0] == pytest.approx(np.cov(points.T, bias=True), rel=1e-3)
    assert np.median(fitted.curvature_.absolute) == pytest.approx(
        np.median(LPSimplifier(target_reduction=0.5).fit(bumpy(800)).curvature_.absolute) / 50, rel=1e-6
    )


def test_responsibilities_survive_coordinates_far_from_the_origin():
    points = bumpy(800)
    far = points + np.array([5e5, 4e6, 120.0])
    fits = [LPSimplifier(target_reduction=0.5, n_clusters=4).fit(p) for p in (points, far)]
    near, other = (f.responsibilities(p) for f, p in zip(fits, (points, far), strict=True))
    assert np.allclose(near, other, atol=1e-5)


def test_fit_resample_returns_the_kept_points(fitted):
    points = bumpy(1500)
    kept, rows = clone(fitted).fit_resample(points, np.arange(1500))
    assert np.array_equal(kept, points[fitted.sample_indices_])
    assert np.array_equal(rows, fitted.sample_indices_)


def test_kept_features_are_features_and_fill_their_share():
    fitted = LPSimplifier(target_reduction=0.5, n_clusters=4, feature_share=0.4).fit(bumpy(2000))
    kept = fitted.feature_mask_[fitted.sample_indices_].mean()
    assert kept >= 0.39


@settings(max_examples=15)
@given(
    n_points=st.integers(1, 120),
    seed=st.integers(0, 999),
    reduction=st.floats(0, 0.999),
    n_clusters=st.integers(1, 12),
    method=st.sampled_from(["lp_density", "lp_printed"]),
)
def test_exactly_the_target_stays_and_it_is_a_subset(n_points, seed, reduction, n_clusters, method):
    points = np.random.default_rng(seed).normal(size=(n_points, 3))
    result = simplify(points, target_reduction=reduction, n_clusters=n_clusters, method=method)
    assert len(result) == max(1, int(np.floor(round((1 - reduction) * n_points, 9))))
    assert np.array_equal(points[result.indices], result.points)


@settings(max_examples=12)
@given(
    seed=st.integers(0, 9999),
    power=st.integers(-40, 40),
    method=st.sampled_from(["lp_density", "lp_printed"]),
)
def test_powers_of_two_change_nothing(seed, power, method):
    points = bumpy(500, seed)
    still = simplify(points, target_reduction=0.8, n_clusters=5, method=method)
    scaled = simplify(points * 2.0**power, target_reduction=0.8, n_clusters=5, method=method)
    assert np.array_equal(still.indices, scaled.indices)


@settings(max_examples=25)
@given(
    seed=st.integers(0, 9999),
    scale=st.floats(1e-3, 1e3),
    shift=st.floats(-100, 100),
    method=st.sampled_from(["lp_density", "lp_printed"]),
)
def test_rotation_translation_and_scale_change_nothing(seed, scale, shift, method):
    points = bumpy(500, seed)
    moved = scale * points @ turn(seed).T + scale * shift
    still, other = (simplify(p, target_reduction=0.8, n_clusters=5, method=method) for p in (points, moved))
    assert np.array_equal(still.indices, other.indices)


@pytest.mark.parametrize("method", ["lp_density", "lp_printed"])
def test_one_thread_and_two_keep_the_same_points(monkeypatch, method):
    points, kept = bumpy(9000), []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("LPCOMPARE_THREADS", threads)
        kept.append(simplify(points, target_reduction=0.9, method=method).indices)
    assert np.array_equal(kept[0], kept[1])
    assert np.array_equal(kept[0], kept[2])


def test_float32_fortran_and_read_only_inputs_keep_the_same_points():
    points = bumpy(700).astype(np.float32).astype(np.float64)
    frozen = points.copy()
    frozen.flags.writeable = False
    variants = [points, points.astype(np.float32), np.asfortranarray(points), frozen]
    kept = [simplify(p, target_count=90).indices for p in variants]
    assert all(np.array_equal(kept[0], k) for k in kept)


def test_seeds_differ_and_repeat():
    points = bumpy(1000)
    first, again, other = (simplify(points, target_count=100, random_state=s).indices for s in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_callback_sees_every_stage_to_its_end():
    seen = []
    simplify(bumpy(5000), target_count=400, callback=lambda *event: seen.append(event))
    stages = [stage for stage, _, _ in seen]
    assert list(dict.fromkeys(stages)) == ["clustering", "curvature", "selection"]
    assert [e for e in seen if e[0] == "curvature"][-1][1:] == (2, 2)
    assert [e for e in seen if e[0] == "selection"][-1][1:] == (20, 20)
    assert all(0 < done <= total for _, done, total in seen)


@pytest.mark.parametrize("stage", ["clustering", "curvature", "selection"])
def test_an_interrupt_leaves_no_thread_behind(monkeypatch, stage):
    monkeypatch.setenv("LPCOMPARE_THREADS", "2")
    before = threading.active_count()

    def interrupt(name, done, total):
        if name == stage:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simplify(bumpy(5000), target_count=400, callback=interrupt)
    assert threading.active_count() == before


SLOW = """
import numpy as np
from lpcompare.paper import certificate, enumeration, program
import lpcompare
points = np.random.default_rng(0).normal(size=(900, 3))
lpcompare.simplify(points, target_count=300, method="lp_density")
# no selection is good enough and none is counted: HiGHS has to search until it is stopped
certificate.TOLERANCE = program.TOLERANCE = 1e-14
enumeration._MOST_SUMS = 10
print("begin", flush=True)
try:
    lpcompare.simplify(points, target_count=300, method="lp_density", n_clusters=3, time_limit=600.0)
except KeyboardInterrupt:
    import threading
    print("stopped", threading.active_count())
"""


@pytest.mark.parametrize("threads", ["1", "2"])
def test_ctrl_c_stops_highs_and_its_threads(threads):
    environment = os.environ | {"LPCOMPARE_THREADS": threads}
    with subprocess.Popen(
        [sys.executable, "-c", SLOW], env=environment, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "begin\n"
        time.sleep(3)
        assert process.poll() is None, "the search ended before it could be stopped"
        process.send_signal(signal.SIGINT)
        try:
            assert process.communicate(timeout=100)[0] == "stopped 1\n"
        finally:
            process.kill()


POINTS = bumpy(50)


@pytest.mark.parametrize(
    ("points", "arguments", "says"),
    [
        (np.empty((0, 3)), {"target_count": 1}, "empty"),
        (np.zeros((5, 2)), {"target_count": 1}, r"\(5, 2\)"),
        (np.zeros(3), {"target_count": 1}, r"\(3,\)"),
        ("cloud.ply", {"target_count": 1}, "real numbers"),
        (np.zeros((4, 3), dtype=complex), {"target_count": 1}, "real numbers"),
        ([[1, 2, 3], [4, 5]], {"target_count": 1}, "real numbers"),
        (np.vstack([POINTS, [[0, np.nan, 0]]]), {"target_count": 1}, "row 50"),
        (np.vstack([POINTS, [[np.inf, 0, 0]]]), {"target_count": 1}, "infinity"),
        (POINTS, {}, "exactly one"),
        (POINTS, {"target_count": 5, "target_reduction": 0.5}, "exactly one"),
        (POINTS, {"target_count": 0}, "from 1 to 50"),
        (POINTS, {"target_count": 51}, "from 1 to 50"),
        (POINTS, {"target_count": 2.5}, "integer"),
        (POINTS, {"target_count": True}, "integer"),
        (POINTS, {"target_reduction": 1.5}, "from 0 to 1"),
        (POINTS, {"target_reduction": -0.1}, "from 0 to 1"),
        (POINTS, {"target_reduction": 1.0}, "no point"),
        (POINTS, {"target_reduction": np.nan}, "from 0 to 1"),
        (POINTS, {"target_reduction": "0.5"}, "from 0 to 1"),
        (POINTS, {"target_count": 5, "n_clusters": 0}, "n_clusters"),
        (POINTS, {"target_count": 5, "n_neighbors": -1}, "n_neighbors"),
        (POINTS, {"target_count": 5, "feature_share": 2}, "feature_share"),
        (POINTS, {"target_count": 5, "time_limit": -1}, "time_limit"),
        (POINTS, {"target_count": 5, "gap": np.nan}, "gap"),
        (POINTS, {"target_count": 5, "random_state": "x"}, "random_state"),
        (POINTS, {"target_count": 5, "random_state": -3}, "random_state"),
    ],
)
def test_what_cannot_be_worked_on_is_one_sentence(points, arguments, says):
    with pytest.raises(InputError, match=says) as error:
        simplify(points, **arguments)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["method", "retention", "density", "clusterer", "solver"])
def test_unknown_words_name_the_known_ones(name):
    with pytest.raises(UnknownName, match="Known"):
        simplify(POINTS, target_count=5, **{name: "nosuch"})


def test_settings_are_checked_before_the_work():
    seen = []
    with pytest.raises(UnknownName):
        simplify(POINTS, target_count=5, solver="nosuch", callback=lambda *event: seen.append(event))
    assert not seen


@pytest.mark.shared
@pytest.mark.parametrize("n_clusters", [20, 25])
def test_keeping_the_features_of_the_bunny_leaves_the_papers_count(shared_models, n_clusters):
    lines = (shared_models / "upstream" / "stanford-bunny.obj").read_text(encoding="utf-8").splitlines()
    points = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
    result = simplify(
        points, target_reduction=0.7, n_clusters=n_clusters, retention="keep-features", method="lp_printed"
    )
    assert len(points) == 35947
    assert len(result) == pytest.approx(20130, rel=0.01)
    assert result.info["n_certified"] == len(result.info["certificates"])
