"""The estimator checks of scikit-learn."""

import warnings

import fos_imu as fos
import numpy as np
import pytest

sklearn = pytest.importorskip("sklearn")

from sklearn.base import clone  # noqa: E402
from sklearn.model_selection import GridSearchCV, TimeSeriesSplit  # noqa: E402
from sklearn.pipeline import make_pipeline  # noqa: E402
from sklearn.preprocessing import StandardScaler  # noqa: E402
from sklearn.utils.estimator_checks import check_estimator  # noqa: E402

DYNAMIC = "rows are samples in the order of time: what comes before a row is part of what is predicted for it"
FEW = "of fewer than five samples a candidate nothing is learnt: they are refused, with what would fit"

# with the reason for each
NOT_IN_ANY_ORDER = dict.fromkeys(["check_methods_sample_order_invariance", "check_methods_subset_invariance"], DYNAMIC)
TOO_FEW_SAMPLES = dict.fromkeys(
    [
        "check_dict_unchanged",
        "check_dont_overwrite_parameters",
        "check_dtype_object",
        "check_estimators_dtypes",
        "check_estimators_nan_inf",
        "check_f_contiguous_array_estimator",
        "check_fit2d_1feature",
        "check_fit2d_predict1d",
        "check_n_features_in_after_fitting",
        "check_regressors_int",
        "check_regressors_no_decision_function",
    ],
    FEW,
)


class Repeated(fos.FosRegressor):
    """With samples enough: those of a check over and over."""

    def fit(self, X, y, groups=None):
        if not hasattr(X, "toarray") and y is not None:
            X, y = np.asarray(X), np.asarray(y)
            if X.ndim == 2 and 1 < len(X) == len(y) < 100:
                X, y = np.tile(X, (20, 1)), np.concatenate([y] * 20)
        return super().fit(X, y, groups)


def check(estimator, expected):
    with warnings.catch_warnings():
        # it does not inherit from BaseEstimator: scikit-learn is not needed for it
        warnings.simplefilter("ignore")
        results = check_estimator(estimator, expected_failed_checks=expected, on_fail=None, on_skip=None)
    failed = {one["check_name"]: repr(one["exception"]) for one in results if one["status"] == "failed"}
    assert failed == {}
    status = {one["check_name"]: one["status"] for one in results}
    # a reason that no longer holds is not kept
    assert {name: status[name] for name in expected} == dict.fromkeys(expected, "xfail")
    return [one["check_name"] for one in results if one["status"] == "passed"]


def test_the_estimator_checks_that_apply_pass():
    passed = check(fos.FosRegressor(max_lag=1, degree=1), NOT_IN_ANY_ORDER | TOO_FEW_SAMPLES)
    assert len(passed) >= 38


def test_those_with_too_few_samples_pass_with_enough():
    passed = check(Repeated(max_lag=1, degree=1), NOT_IN_ANY_ORDER)
    assert set(TOO_FEW_SAMPLES) <= set(passed)


def test_it_goes_into_a_search_and_a_pipeline():
    random = np.random.default_rng(2)
    X = random.normal(size=(600, 2))
    y = np.zeros(600)
    for k in range(1, 600):
        y[k] = 0.6 * y[k - 1] + X[k - 1, 0] + 0.05 * random.normal()
    search = GridSearchCV(
        fos.FosRegressor(degree=1, input_lags=1), {"max_lag": [1, 2]}, cv=TimeSeriesSplit(3), error_score="raise"
    )
    search.fit(X, y)
    assert search.best_score_ > 0.9
    piped = make_pipeline(StandardScaler(), fos.FosRegressor(max_lag=1, degree=1, input_lags=1)).fit(X, y)
    assert piped.score(X, y) > 0.9
    assert clone(search.best_estimator_).get_params() == search.best_estimator_.get_params()
