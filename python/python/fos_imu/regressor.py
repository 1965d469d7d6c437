"""Fast Orthogonal Search as a regressor with the interface of scikit-learn, which is not needed for it."""

from __future__ import annotations

import copyreg
import inspect
import json
import sys
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
import numpy.typing as npt

from . import _engine
from ._columns import columns_of, unmasked
from ._results import build
from .errors import RegressorError

if TYPE_CHECKING:
    from typing_extensions import Self

Floats = npt.NDArray[np.float64]

copyreg.pickle(_engine.SeriesModel, lambda model: (_engine.SeriesModel.from_json, model.to_json()))


@dataclass(frozen=True)
class RegressorTerm:
    """A term of the model.

    Attributes:
        monomial: As people write it: `y(n-1)·x0(n-2)`.
        coefficient: Unit of the output per unit of the product.
        standard_error: Of it, of white residuals; None where it was not estimated.
    """

    monomial: str
    coefficient: float
    standard_error: float | None


@dataclass(frozen=True)
class RegressorReport:
    """How the model was found: y(n) = constant + Σ terms, with output and inputs centred first.

    Attributes:
        constant: Unit of the output.
        terms: In the order in which they were chosen.
        centres: Name and mean of output and inputs, if these were centred; else empty.
        candidates: Monomials that were searched.
        rows: Samples that counted.
        stopped: Why the search stopped.
        condition_number: Of the final terms, columns scaled.
        mse: Mean square of the one-step prediction error on the training data, unit² of the output.
    """

    constant: float
    terms: tuple[RegressorTerm, ...]
    centres: tuple[tuple[str, float], ...]
    candidates: int
    rows: int
    stopped: str
    condition_number: float
    mse: float


class FosRegressor:
    """A polynomial NARX model, y(n) = Σ c·Π y(n−l)·Π x_i(n−k), found by Fast Orthogonal Search.

    Rows are samples in the order of time, `X` are inputs of the same instants: the model is dynamic, and rows must not be
    shuffled (`sklearn.model_selection.TimeSeriesSplit`, not `KFold`).

    Args:
        max_lag: L: output lags 1 … L are candidates, samples; 0: the inputs alone.
        input_lags: K: input lags 0 … K are candidates, samples.
        degree: Cross-product degree, 1, 2 or 3: products of up to so many lags are candidates.
        max_terms: Most terms.
        search: Whether terms are exchanged until nothing improves, or the best next one is taken as in the paper.
        stop: When to stop before: allowing for the number of candidates, by Korenberg's test, never.
        centre: Take the means off output and inputs first: for signals whose mean dwarfs what they vary by. The terms are
            then products of the centred values, not of the signals.

    Attributes:
        n_features_in_: Columns of X.
        feature_names_in_: Their names, where X had names.
        report_: How the model was found, a `RegressorReport`.
        terms_: Its terms.
    """

    def __init__(
        self,
        *,
        max_lag: int = 10,
        input_lags: int = 0,
        degree: int = 2,
        max_terms: int = 20,
        search: Literal["exchange", "greedy"] = "exchange",
        stop: Literal["multiplicity", "korenberg", "never"] = "multiplicity",
        centre: bool = False,
    ) -> None:
        self.max_lag = max_lag
        self.input_lags = input_lags
        self.degree = degree
        self.max_terms = max_terms
        self.search = search
        self.stop = stop
        self.centre = centre

    def fit(self, X: object, y: object, groups: object = None) -> Self:
        """Finds the model.

        Args:
            X: Inputs, shape `(n_samples, n_features)`; an array, a DataFrame, or None for a series without inputs. A
                column that never changes is excluded.
            y: Output, shape `(n_samples,)`.
            groups: Label of every sample, shape `(n_samples,)`: where it changes a new stretch begins, and nothing is
                learnt across.

        Raises:
            RegressorError: Shapes that do not go together, values that are not finite.
            FitError: Too few samples for so many candidates; the message says what fits.
        """
        output = _output(y)
        inputs, names = _inputs(X, output.size)
        if output.size != len(inputs):
            raise RegressorError(
                f"X has {len(inputs)} samples, y has {output.size}: inconsistent numbers of samples",
                remedy="one row of X for every value of y",
            )
        if output.size < 2:
            raise RegressorError(
                f"1 sample (n_samples=1) is too few: n_samples is {output.size}", remedy="more samples"
            )
        labels = None if groups is None else _labels(groups, output.size)
        steady = np.ptp(inputs, axis=0) == 0 if len(inputs) else np.zeros(inputs.shape[1], bool)
        varying = np.flatnonzero(~steady)
        said = names if names is not None else [f"x{index}" for index in range(inputs.shape[1])]
        options: dict[str, Any] = {
            "max_lag": self.max_lag,
            "input_lags": self.input_lags,
            "degree": self.degree,
            "max_terms": self.max_terms,
            "search": self.search,
            "stop": self.stop,
            "centre": self.centre,
        }
        if np.ptp(output) == 0:
            raise RegressorError("y is one value throughout", remedy="an output that changes")
        chosen = [said[index] for index in varying]
        model = _engine.fit_series(output, inputs[:, varying], labels, chosen, options)
        self.n_features_in_ = inputs.shape[1]
        if names is not None:
            self.feature_names_in_ = np.asarray(names, dtype=object)
        elif hasattr(self, "feature_names_in_"):
            del self.feature_names_in_
        self.report_ = build(RegressorReport, json.loads(model.to_json()[2]))
        self._varying = varying
        self._model = model
        # what a forecast goes on from: the last stretch, as far as it is remembered
        begin = 0 if labels is None else int(np.flatnonzero(_starts(labels))[-1])
        begin = max(begin, output.size - max(model.depth, 1))
        self._last_output, self._last_inputs = output[begin:].copy(), inputs[begin:].copy()
        return self

    @property
    def terms_(self) -> tuple[RegressorTerm, ...]:
        """The terms of the model."""
        self._check_is_fitted()
        return self.report_.terms

    def predict(
        self,
        X: object = None,
        *,
        y: object = None,
        steps: int | None = None,
        y_init: object = None,
        groups: object = None,
    ) -> Floats:
        """What the model says, in one of three ways.

        Args:
            X: Inputs, shape `(n_samples, n_features)`; None of a model without inputs.
            y: Measured output, shape `(n_samples,)`: every sample is predicted one step ahead, from the measured ones
                before it; the first ones, before a history is there, by the mean.
            steps: So many samples behind the training data are forecast; X are their inputs.
            y_init: Measured output of the first rows of X, which the own run goes on from; these rows are not predicted.
            groups: Labels, with y: the history restarts where they change.

        Returns:
            Shape `(n_samples,)`, less the rows of `y_init`, unit of the output. Without y and steps from the model's own
            history, which begins at rest: the output at its mean, the inputs as they are in the first row. Own history is
            kept within twice the range of the training data.
        """
        self._check_is_fitted()
        if y is not None:
            output = _output(y)
            inputs = self._inputs_again(X, output.size)
            starts = np.zeros(output.size, bool) if groups is None else _starts(_labels(groups, output.size))
            return self._model.one_step(output, inputs, starts.tolist())
        if steps is not None:
            later = self._inputs_again(X, steps)
            inputs = np.concatenate([self._last_inputs[:, self._varying], later])
            return self._model.free_run(self._last_output, inputs)
        if X is None and self.n_features_in_:
            raise RegressorError("the model has inputs and X is None", remedy="give X, or steps and X")
        if X is None:
            raise RegressorError("how many samples?", remedy="give steps, or y for one step ahead")
        history = np.zeros(0) if y_init is None else _output(y_init)
        return self._model.free_run(history, self._inputs_again(X, None))

    def score(self, X: object, y: object, *, one_step: bool = False, groups: object = None) -> float:
        """R² of `predict(X)`, the model's own run; of one step ahead if `one_step`. At most 1; 0 of the mean."""
        output = _output(y)
        ahead = one_step or X is None
        predicted = self.predict(X, y=output, groups=groups) if ahead else self.predict(X)
        left = float(((output - predicted) ** 2).sum())
        about = float(((output - output.mean()) ** 2).sum())
        return 1.0 - left / about if about > 0 else float(left == 0)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """What it was made with."""
        return {
            name: getattr(self, name) for name in inspect.signature(type(self).__init__).parameters if name != "self"
        }

    def set_params(self, **params: Any) -> Self:  # noqa: ANN401
        """Sets what it was made with."""
        known = self.get_params()
        for name, value in params.items():
            if name not in known:
                raise ValueError(
                    f"Invalid parameter {name!r} for estimator {self!r}. Valid parameters are: {sorted(known)!r}."
                )
            setattr(self, name, value)
        return self

    def __repr__(self) -> str:
        defaults = inspect.signature(type(self).__init__).parameters
        given = (f"{name}={value!r}" for name, value in self.get_params().items() if value != defaults[name].default)
        return f"{type(self).__name__}({', '.join(given)})"

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "_model")

    def __sklearn_tags__(self) -> Any:  # noqa: ANN401
        """Asked for by scikit-learn alone, which is then there."""
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags  # pyright: ignore

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True),
            regressor_tags=RegressorTags(),
            input_tags=InputTags(),
        )

    def _check_is_fitted(self) -> None:
        if not hasattr(self, "_model"):
            raise _not_fitted()(f"This {type(self).__name__} instance is not fitted yet", remedy="call fit first")

    def _inputs_again(self, X: object, rows: int | None) -> Floats:
        """The inputs that the model uses, checked against those of the fit."""
        inputs, names = _inputs(X, rows)
        fitted = cast("npt.NDArray[np.object_] | None", getattr(self, "feature_names_in_", None))
        _check_names(type(self).__name__, names, fitted, named=X is not None)
        if inputs.shape[1] != self.n_features_in_:
            raise RegressorError(
                f"X has {inputs.shape[1]} features, but {type(self).__name__} is expecting {self.n_features_in_} features "
                "as input"
            )
        if rows is not None and len(inputs) != rows:
            raise RegressorError(f"X has {len(inputs)} samples, {rows} are needed: inconsistent numbers of samples")
        return inputs[:, self._varying]


def _inputs(X: object, rows: int | None) -> tuple[Floats, list[str] | None]:
    """Samples × features, and the names of the features where they have names."""
    if X is None:
        return np.zeros((rows or 0, 0)), None
    if hasattr(X, "toarray") or type(X).__module__.startswith("scipy.sparse"):
        raise RegressorError("X is sparse: Sparse data was passed, but dense data is required", remedy="X.toarray()")
    names = None
    if hasattr(X, "columns") or hasattr(X, "column_names"):
        columns = columns_of(X)
        raw = cast("Any", X).columns if hasattr(X, "columns") else cast("Any", X).column_names
        names = [name for name, _ in columns] if all(isinstance(name, str) for name in raw) else None
        array = np.column_stack([values for _, values in columns]) if columns else np.zeros((rows or 0, 0))
    else:
        array = np.asarray(unmasked(X))
    if np.iscomplexobj(array):
        raise RegressorError("Complex data not supported")
    if array.ndim != 2:
        raise RegressorError(
            f"Expected 2D array, got {array.ndim}D array instead",
            remedy="Reshape your data: X.reshape(-1, 1) of one feature, X.reshape(1, -1) of one sample",
        )
    numbers = _numbers("X", array)
    if numbers.shape[0] == 0:
        raise RegressorError(f"Found array with 0 sample(s) (shape={numbers.shape}) while a minimum of 1 is required.")
    if numbers.shape[1] == 0 and names is None:
        raise RegressorError(
            f"Found array with 0 feature(s) (shape={numbers.shape}) while a minimum of 1 is required.",
            remedy="X=None of a series without inputs",
        )
    return numbers, names


def _output(y: object) -> Floats:
    if y is None:
        raise RegressorError("requires y to be passed, but the target y is None")
    array = np.asarray(cast("Any", y).to_numpy() if hasattr(y, "to_numpy") else unmasked(y))
    if np.iscomplexobj(array):
        raise RegressorError("Complex data not supported")
    if array.ndim == 2 and array.shape[1] == 1:
        warnings.warn("A column-vector y was passed when a 1d array was expected.", _conversion_warning(), stacklevel=3)
        array = array[:, 0]
    if array.ndim != 1:
        raise RegressorError(f"y should be a 1d array, got an array of shape {array.shape} instead.")
    return _numbers("y", array)


def _numbers(what: str, array: npt.NDArray[Any]) -> Floats:
    try:
        numbers = np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        if isinstance(error, TypeError):
            raise
        raise RegressorError(f"{what} is no array of numbers: {error}") from None
    if not np.isfinite(numbers).all():
        raise RegressorError(f"Input {what} contains NaN, infinity or a value too large for dtype('float64').")
    return numbers


def _labels(groups: object, rows: int) -> Floats:
    array = np.asarray(groups)
    if array.shape != (rows,):
        raise RegressorError(f"groups has shape {array.shape}, ({rows},) is needed")
    return np.unique(array, return_inverse=True)[1].astype(np.float64)


def _starts(labels: Floats) -> npt.NDArray[np.bool_]:
    return np.concatenate([[True], labels[1:] != labels[:-1]])


def _check_names(
    regressor: str, names: list[str] | None, fitted: npt.NDArray[np.object_] | None, *, named: bool
) -> None:
    """The rules of scikit-learn for names of features, in its words."""
    if not named or (names is None and fitted is None):
        return
    if fitted is None:
        text = f"X has feature names, but {regressor} was fitted without feature names"
        warnings.warn(text, UserWarning, stacklevel=4)
    elif names is None:
        text = f"X does not have valid feature names, but {regressor} was fitted with feature names"
        warnings.warn(text, UserWarning, stacklevel=4)
    elif names != list(fitted):
        seen = [str(name) for name in fitted]
        unseen = sorted(set(names) - set(seen))
        missing = sorted(set(seen) - set(names))
        message = "The feature names should match those that were passed during fit.\n"
        for title, listed in (("unseen at fit time", unseen), ("seen at fit time, yet now missing", missing)):
            if listed:
                message += f"Feature names {title}:\n" + "".join(f"- {name}\n" for name in listed[:5])
        if not unseen and not missing:
            message += "Feature names must be in the same order as they were in fit.\n"
        raise RegressorError(message)


def _not_fitted() -> type[RegressorError]:
    """Where scikit-learn is in use, an error that it knows too."""
    exceptions = sys.modules.get("sklearn.exceptions")
    if exceptions is None:
        return RegressorError
    return type("NotFittedError", (RegressorError, exceptions.NotFittedError), {})


def _conversion_warning() -> type[Warning]:
    exceptions = sys.modules.get("sklearn.exceptions")
    return UserWarning if exceptions is None else exceptions.DataConversionWarning
