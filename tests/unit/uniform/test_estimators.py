"""Both estimators keep scikit-learn's habits and imbalanced-learn's `fit_resample`."""

import warnings
from functools import partial

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils.estimator_checks import parametrize_with_checks

from lpcompare import LPSimplifier, UniformSimplifier
from lpcompare.paper.clustering import cluster_points

CLOUD = np.random.default_rng(0).normal(size=(300, 3)) * [1.0, 1.0, 0.1]
ESTIMATORS = [
    LPSimplifier(target_reduction=0.5, n_clusters=2),
    UniformSimplifier(target_reduction=0.5, n_clusters=2),
]
THREE_COLUMNS = "the check fits a table that is no cloud: not three columns of real numbers"
EXCEPTIONS = dict.fromkeys(
    [
        "check_complex_data",
        "check_dtype_object",
        "check_estimator_sparse_array",
        "check_estimator_sparse_matrix",
        "check_estimator_sparse_tag",
        "check_estimators_dtypes",
        "check_estimators_empty_data_messages",
        "check_estimators_fit_returns_self",
        "check_estimators_overwrite_params",
        "check_fit2d_1feature",
        "check_fit2d_1sample",
        "check_fit_check_is_fitted",
        "check_fit_idempotent",
        "check_n_features_in",
        "check_n_features_in_after_fitting",
        "check_positive_only_tag_during_fit",
        "check_readonly_memmap_input",
    ],
    THREE_COLUMNS,
)


@parametrize_with_checks(ESTIMATORS, expected_failed_checks=lambda _: EXCEPTIONS)
def test_checks_of_scikit_learn(estimator, check):
    check(estimator)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_what_the_exceptions_would_check_holds_for_clouds(estimator):
    cloud = CLOUD.copy()
    cloud.flags.writeable = False
    first, settings = clone(estimator), estimator.get_params()
    assert first.fit(cloud) is first
    assert first.get_params() == settings
    assert first.n_features_in_ == 3
    kept = first.sample_indices_
    for same in (first.fit(cloud), clone(estimator).fit(cloud), clone(estimator).fit(cloud.tolist())):
        assert np.array_equal(same.sample_indices_, kept)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_fit_resample_takes_what_belongs_to_the_points_along(estimator):
    values = np.arange(len(CLOUD)) * 10
    points, kept_values = clone(estimator).fit_resample(CLOUD, values)
    assert np.array_equal(CLOUD[kept_values // 10], points)
    again, nothing = clone(estimator).fit_resample(CLOUD)
    assert np.array_equal(again, points)
    assert nothing is None


def test_placed_points_keep_the_values_of_the_rows_they_come_from():
    estimator = UniformSimplifier(target_count=50, n_clusters=2, placed=True)
    points, values = estimator.fit_resample(CLOUD, np.arange(len(CLOUD)))
    assert np.array_equal(values, estimator.sample_indices_)
    assert np.array_equal(values, estimator.simplification_.info["source"])
    assert points.shape == (50, 3)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_fit_that_does_not_converge_warns_and_says_so(estimator, monkeypatch):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fitted = clone(estimator).fit(CLOUD)
    assert fitted.converged_
    assert fitted.n_iter_ == len(fitted.mixture_.log_likelihoods) > 1
    monkeypatch.setattr("lpcompare.paper.thinning.cluster_points", partial(cluster_points, max_iterations=1))
    with pytest.warns(ConvergenceWarning, match="in 1 iteration"):
        fitted = clone(estimator).fit(CLOUD)
    assert not fitted.converged_
    assert fitted.n_iter_ == 1


def test_every_cell_has_one_kept_point_and_a_point_of_its_own():
    fitted = UniformSimplifier(target_count=60, n_clusters=3).fit(CLOUD)
    assert np.array_equal(np.unique(fitted.cells_), np.arange(60))
    assert np.array_equal(fitted.cells_[fitted.sample_indices_], np.arange(60))
    assert len(fitted.labels_) == len(fitted.curvature_.absolute) == len(CLOUD)
    assert len(fitted.certificates_) == 3
