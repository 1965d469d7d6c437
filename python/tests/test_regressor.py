import copy
import pickle

import fos_imu as fos
import numpy as np
import pytest
from fos_imu.errors import FitError, RegressorError


def plant(n=3000, seed=1, noise=0.0):
    """y(n) = 0.5·y(n−1) + 0.8·x(n−2) + x(n−1)² + 0.2 + e(n)."""
    random = np.random.default_rng(seed)
    x = random.uniform(-1, 1, n)
    y = np.zeros(n)
    for k in range(2, n):
        y[k] = 0.5 * y[k - 1] + 0.8 * x[k - 2] + x[k - 1] ** 2 + 0.2 + noise * random.normal()
    return x.reshape(-1, 1), y


def test_a_known_plant_is_recovered_term_by_term():
    X, y = plant()
    found = fos.FosRegressor(max_lag=3, input_lags=3).fit(X, y)
    of = {term.monomial: term.coefficient for term in found.terms_}
    assert of == pytest.approx({"y(n-1)": 0.5, "x0(n-2)": 0.8, "x0(n-1)²": 1.0}, abs=1e-9)
    assert found.report_.constant == pytest.approx(0.2, abs=1e-9)
    X2, y2 = plant(seed=2)
    assert found.score(X2, y2) > 0.999
    np.testing.assert_allclose(found.predict(X2)[50:], y2[50:], atol=1e-6)
    np.testing.assert_allclose(found.predict(X2, y=y2)[5:], y2[5:], atol=1e-6)


def test_a_forecast_goes_on_behind_the_training_data():
    X, y = plant(2000)
    found = fos.FosRegressor(max_lag=2, input_lags=2).fit(X[:1900], y[:1900])
    np.testing.assert_allclose(found.predict(X[1900:], steps=100), y[1900:], atol=1e-6)
    # the same from the measured rows themselves
    series = np.sin(0.05 * np.arange(3000)) + np.random.default_rng(3).normal(0, 0.01, 3000)
    alone = fos.FosRegressor(max_lag=10, degree=1).fit(None, series)
    ahead = alone.predict(steps=20)
    np.testing.assert_allclose(ahead, np.sin(0.05 * np.arange(3000, 3020)), atol=0.1)
    assert alone.score(None, series) > 0.99


def test_what_is_known_is_within_its_standard_error():
    X, y = plant(5000, noise=0.1)
    found = fos.FosRegressor(max_lag=3, input_lags=3).fit(X, y)
    truth = {"y(n-1)": 0.5, "x0(n-2)": 0.8, "x0(n-1)²": 1.0}
    assert {term.monomial for term in found.terms_} == set(truth)
    for term in found.terms_:
        # four standard errors: once in 16,000
        assert abs(term.coefficient - truth[term.monomial]) < 4 * term.standard_error


def test_a_mean_that_dwarfs_the_signal_is_taken_off():
    X, y = plant(2000, noise=0.01)
    found = fos.FosRegressor(max_lag=2, input_lags=2, centre=True).fit(X + 1e6, y + 1e7)
    assert found.score(X + 1e6, y + 1e7) > 0.99
    assert dict(found.report_.centres)["y"] == pytest.approx(1e7, rel=1e-3)


def test_inputs_alone_need_no_history():
    X, _y = plant(500)
    static = 2.0 * X[:, 0] + X[:, 0] ** 2
    found = fos.FosRegressor(max_lag=0).fit(X, static)
    np.testing.assert_allclose(found.predict(X[:3]), static[:3], atol=1e-9)


def test_an_own_run_goes_on_from_what_was_measured():
    X, y = plant(1000)
    found = fos.FosRegressor(max_lag=2, input_lags=2).fit(X, y)
    X2, y2 = plant(100, seed=5)
    np.testing.assert_allclose(found.predict(X2, y_init=y2[:4]), y2[4:], atol=1e-8)


def test_nothing_is_learnt_or_predicted_across_groups():
    X, y = plant(1500)
    X2, y2 = plant(1500, seed=9)
    groups = np.array(["a"] * 1500 + ["b"] * 1500)
    X, y = np.concatenate([X, X2]), np.concatenate([y, 100 * (y2 > 10) + y2])
    apart = fos.FosRegressor(max_lag=2, input_lags=2).fit(X, y, groups=groups)
    assert apart.score(X, y, one_step=True, groups=groups) > 0.99
    one_step = apart.predict(X, y=y, groups=groups)
    # at the begin of the second group its history is not the first group's
    assert one_step[1500] == pytest.approx(one_step[0], abs=1.0)
    with pytest.raises(RegressorError, match="groups has shape"):
        apart.fit(X, y, groups=groups[:-1])


def test_copies_predict_the_same():
    X, y = plant(800, noise=0.1)
    found = fos.FosRegressor(max_lag=2, input_lags=2).fit(X, y)
    for again in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert np.array_equal(again.predict(X), found.predict(X))
        assert np.array_equal(again.predict(X[:9], steps=9), found.predict(X[:9], steps=9))
        assert again.report_ == found.report_


def test_names_of_columns_are_names_of_inputs():
    pandas = pytest.importorskip("pandas")
    X, y = plant(800)
    frame = pandas.DataFrame({"pressure": X[:, 0], "steady": 3.0})
    found = fos.FosRegressor(max_lag=2, input_lags=2).fit(frame, y)
    assert any("pressure" in term.monomial for term in found.terms_)
    assert list(found.feature_names_in_) == ["pressure", "steady"]
    with pytest.raises(RegressorError, match="unseen at fit time"):
        found.predict(frame.rename(columns={"pressure": "force"}))


def test_what_cannot_be_done_says_why():
    X, y = plant(100)
    with pytest.raises(FitError, match="`max_lag`"):
        fos.FosRegressor().fit(X, y)
    with pytest.raises(ValueError, match="Invalid parameter"):
        fos.FosRegressor().set_params(lags=3)
    with pytest.raises(RegressorError, match="call fit first"):
        fos.FosRegressor().predict(X)
    found = fos.FosRegressor(max_lag=1, input_lags=1, degree=1).fit(X, y)
    with pytest.raises(RegressorError, match="X is None"):
        found.predict()
    with pytest.raises(RegressorError, match="is expecting 1 features"):
        found.predict(np.zeros((3, 2)))


def test_it_says_what_it_was_made_with():
    made = fos.FosRegressor(max_lag=3, stop="never")
    assert repr(made) == "FosRegressor(max_lag=3, stop='never')"
    assert fos.FosRegressor(**made.get_params()).get_params() == made.get_params()
    assert made.set_params(degree=1).degree == 1
