"""A study: the model of one unit, what was added to it, and the logs behind it; one file, the same as the program's."""

from __future__ import annotations

import functools
import json
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from . import _engine, _html
from ._results import build
from .comparison import Comparison, ModelErrors
from .diagnosis import Cost, Diagnosis, Finding, diagnosis_of, finding_of
from .errors import FosWarning
from .figure import Figure
from .recording import Path, Recording, Source, engine_of

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Left:
    """Residual after the physical part, on the evaluated rows.

    Attributes:
        slow: Variance of 1-s means, unit².
        wide: Variance of the samples, unit².
        bias: What the bias is off by there, unit; None where the log does not tell.
    """

    slow: float
    wide: float
    bias: float | None = None


@dataclass(frozen=True)
class Added:
    """An effect that was added.

    Attributes:
        effect: Its identifier.
        finding: What it was found to be, with the reduction that is predicted.
        measured_reduction: The reduction that was measured on rows that were not fitted, in the band of the effect.
    """

    effect: str
    finding: Finding
    measured_reduction: float


@dataclass(frozen=True)
class Step:
    """A state of the model of an axis, and its errors on rows that were not fitted.

    Attributes:
        added: What was added; None in the state before.
        errors: All errors.
        left: What the physical part leaves.
        cost: What the axis costs on the device.
    """

    added: Added | None
    errors: ModelErrors
    left: Left
    cost: Cost

    @property
    def name(self) -> str:
        """`before`, or the effect that was added."""
        return "before" if self.added is None else f"+ {self.added.effect}"


@dataclass(frozen=True)
class Refinement:
    """An axis that effects were added to.

    Attributes:
        column: The axis.
        log: The log to explain, on which the model failed.
        reference: The log that fixed the noise; None if there was none.
        evaluation: The evaluation log; None: the rows of the log to explain from `fitted_rows` on.
        fitted_rows: Rows of the log to explain that effects were estimated from.
        steps: The model before anything was added, then after each effect.
        figure: The error after each step.
    """

    column: str
    log: Source
    reference: Source | None
    evaluation: Source | None
    fitted_rows: int
    steps: tuple[Step, ...]
    figure: Figure = field(repr=False)

    def to_pandas(self) -> pandas.DataFrame:
        """One row a step: what was added, the predicted and the measured reduction, the residual, the cost."""
        import pandas

        def row(step: Step) -> dict[str, Any]:
            added = step.added
            return {
                "step": step.name,
                "predicted_reduction": added.finding.predicted_reduction if added else None,
                "measured_reduction": added.measured_reduction if added else None,
                "slow_left": step.left.slow,
                "wide_left": step.left.wide,
                "bias_off": step.left.bias,
                "one_step_mse": step.errors.one_step_mse,
                "terms": step.cost.terms,
                "ram_bytes": step.cost.ram_bytes,
                "instructions": step.cost.instructions,
            }

        return pandas.DataFrame([row(step) for step in self.steps])

    def _repr_html_(self) -> str:
        number, percent = _html.number, _html.rms_percent
        header = (
            "step",
            "predicted reduction",
            "measured",
            "slow error",
            "broadband error",
            "terms",
            "RAM, bytes",
            "instructions",
        )

        def row(step: Step) -> tuple[object, ...]:
            predicted = measured = ""
            if step.added is not None:
                low, high = step.added.finding.predicted_reduction_interval
                predicted = f"{percent(step.added.finding.predicted_reduction)} ({percent(low)} … {percent(high)})"
                measured = percent(step.added.measured_reduction)
            cost = (step.cost.terms, step.cost.ram_bytes, step.cost.instructions)
            return (step.name, predicted, measured, number(step.left.slow**0.5), number(step.left.wide**0.5), *cost)

        evaluated_on = self.evaluation.path if self.evaluation else f"its rows from {self.fitted_rows} on"
        return _html.card(
            f"{self.column}, refined on {self.log.path}, evaluated on {evaluated_on}",
            _html.paragraph(f"left: roots of variances, {_unit(self.column)}, of what the physical part leaves"),
            _html.table(header, [row(step) for step in self.steps]),
            *_html.pictures(self.figure),
        )


@dataclass(frozen=True)
class Term:
    """A term of a fitted axis.

    Attributes:
        monomial: As people write it: `r(n-1)·temp_c`.
        mse_reduction: Q: drop of the mean square error when it was chosen, scaled units.
        error_reduction_ratio: The same over the mean square of the remainder.
        mse: Mean square error after it, scaled units.
    """

    monomial: str
    mse_reduction: float
    error_reduction_ratio: float
    mse: float


@dataclass(frozen=True)
class AxisFit:
    """How an axis was fitted.

    Attributes:
        column: The axis.
        method: `fos`, or an autoregression.
        candidates: Monomials searched, or lags.
        rows: Rows that counted.
        steps: Every term in the order of its selection; none of an autoregression.
        stopped: Why the search stopped.
        condition_number: Of the final terms, columns scaled.
        mse: Mean square of the residual on the rows that were fitted, scaled units.
        mean_square: The same of what was to be explained.
    """

    column: str
    method: str
    candidates: int
    rows: int
    steps: tuple[Term, ...]
    stopped: str
    condition_number: float
    mse: float
    mean_square: float


@dataclass(frozen=True)
class _File:
    axes: tuple[AxisFit, ...]
    sources: tuple[Source, ...] = field(default=())


Method = Literal["fos", "yule-walker", "covariance", "modified-covariance", "burg"]


def fit(
    recordings: Recording | Sequence[Recording],
    *,
    axes: Sequence[str] | str | None = None,
    physical: Sequence[str] = (),
    inputs: Sequence[str] = (),
    input_lags: int = 0,
    method: Method = "fos",
    search: Literal["exchange", "greedy"] = "exchange",
    max_lag: int = 10,
    degree: int = 2,
    memory_s: Sequence[float] = (0.1, 1.0, 10.0, 100.0),
    max_terms: int = 20,
    stop: Literal["multiplicity", "korenberg", "never"] = "multiplicity",
    train: str = "50%",
    offset: float | None = None,
    scale: float | None = None,
    full_scale: float = 0.0,
    factory_corrected: bool = False,
    denoise: str | None = None,
) -> Study:
    """Fits nonlinear autoregressive models of the error of one or more axes, and evaluates them on the remaining rows.

    Args:
        recordings: A log, or several of one unit, in order; one that begins where another ends continues it.
        axes: As `gx`, a column, or several; all that there are if not given.
        physical: Inputs of the physical part, which also holds in motion: `temp_c`, `temp_c:lowpass(60)`,
            `clock:decay(200)`.
        inputs: Inputs offered to the search.
        input_lags: K: lags 0 … K of these inputs are candidates, samples.
        method: How the stochastic part is found.
        search: Whether terms are exchanged until nothing improves, or the best next one is taken as in the paper.
        max_lag: L: output lags 1 … L are candidates, samples; the order of an autoregression.
        degree: Cross-product degree, 1, 2 or 3.
        memory_s: Time constants of low-passes of the output offered beside its lags, s.
        max_terms: Most terms of an axis.
        stop: When to stop before: allowing for the number of candidates, by Korenberg's test, never.
        train: The part of the log, from its start, that is fitted: a share (`"50%"`) or a time (`"180s"`).
        offset: Subtracted from the error instead of its mean, unit of the axis.
        scale: Divides the error instead of its standard deviation, unit of the axis.
        full_scale: Measured values of this magnitude count as saturated, unit of the axis; 0 if not known.
        factory_corrected: The log is after a factory's or driver's correction.
        denoise: De-noise the training data first, for methods other than `fos`: `"db4:4:soft"`.

    Raises:
        RecordingError: A column is missing, or the logs do not go together.
        FitError: The log is too short, an axis is stuck, an option is none.
        CompareError: No row at rest remains for the evaluation.
    """
    logs = [recordings] if isinstance(recordings, Recording) else list(recordings)
    chosen = [axes] if isinstance(axes, str) else axes
    options: dict[str, Any] = {
        "method": method,
        "denoise": denoise,
        "search": search,
        "max_lag": max_lag,
        "degree": degree,
        "memory_s": list(memory_s),
        "inputs": list(inputs),
        "input_lags": input_lags,
        "physical": list(physical),
        "max_terms": max_terms,
        "stop": stop,
        "train": train,
        "offset": offset,
        "scale": scale,
        "full_scale": full_scale,
        "factory_corrected": factory_corrected,
    }
    return Study(_engine.fit([engine_of(log) for log in logs], None if chosen is None else list(chosen), options))


class Study:
    """The model of one unit, fitted and refined. Made by `fit` or `Study.load`.

    Calls from several threads are safe: those that change the study are taken one after the other, and what they change is
    published when it is whole.
    """

    def __init__(self, engine: _engine.Study) -> None:
        """Not to be called: use `fit` or `load`."""
        self._engine = engine

    @classmethod
    def load(cls, path: Path) -> Study:
        """Reads a study that this package or the program (`fos fit`) wrote.

        Raises:
            FileError: It cannot be read.
            StudyError: It is no study, with line and column; or one of another version.
        """
        return cls(_engine.load_study(os.fspath(path)))

    def save(self, path: Path | None = None, *, replace: bool = False) -> None:
        """Writes it atomically, as `fos` reads it.

        Args:
            path: The file; where it was loaded from or saved to before if not given. That file is written only if nobody
                else has written it meanwhile.
            replace: Write over another file.

        Raises:
            StudyError: The file cannot be written, or somebody else was quicker.
        """
        target = path if path is not None else self._engine.path()
        if target is None:
            raise TypeError("save() needs a path the first time")
        self._engine.save(os.fspath(target), replace)

    @property
    def axes(self) -> tuple[str, ...]:
        """The columns of its axes."""
        return tuple(self._engine.columns())

    @property
    def fits(self) -> tuple[AxisFit, ...]:
        """How each axis was fitted."""
        return build(_File, self._json()).axes

    @property
    def sources(self) -> tuple[Source, ...]:
        """The logs that were fitted."""
        data = self._json()["data"]
        return build(_File, {"axes": (), "sources": data["sources"]}).sources

    @property
    def cost(self) -> Cost:
        """What terms and inputs of all axes cost on the device."""
        return build(Cost, json.loads(self._engine.cost()))

    @property
    def history(self) -> tuple[Refinement, ...]:
        """The axes that effects were added to, with every step."""
        return tuple(_refinement(**one) for one in json.loads(self._engine.history()))

    def compare(self, log: Recording | None = None) -> Comparison:
        """The model against the measurements and against plain rivals.

        Args:
            log: By default the study's own, evaluated on the rows that were not fitted.

        Raises:
            CompareError: No row at rest remains for the evaluation.
            RecordingError: The log is not at hand, or a column is missing.
        """
        evaluated = self._engine.compare(engine_of(log))
        _warn_of(evaluated.lags_off)
        comparison = build(Comparison, json.loads(evaluated.json()))
        time_s, rows = evaluated.rows()
        axes = (
            replace(
                axis,
                time_s=time_s,
                measured=measured,
                innovation=innovation,
                left=left,
                draw=functools.partial(evaluated.figures, index),
            )
            for index, (axis, (measured, innovation, left)) in enumerate(zip(comparison.axes, rows, strict=True))
        )
        return replace(comparison, axes=tuple(axes))

    def diagnose(
        self,
        log: Recording | None = None,
        *,
        axis: str | None = None,
        reference: Recording | None = None,
        evaluate_on: Recording | None = None,
        effects: Sequence[Path] = (),
    ) -> Diagnosis:
        """Identifies the effects that the model of an axis lacks on a log.

        Args:
            log: The log to explain; by default the log that the axis was refined on.
            axis: As `gx`, or a column; needed where the study has several.
            reference: A reference log of the same device; by default the one that was fitted.
            evaluate_on: The evaluation log; by default the last two fifths of `log`.
            effects: Effects of your own, one TOML file each.

        Raises:
            DiagnoseError: The log is too short, or the axis is stuck.
            RecordingError: A log is not at hand, or a column is missing.
        """
        files = [os.fspath(path) for path in effects]
        answer = self._engine.diagnose(engine_of(log), axis, engine_of(reference), engine_of(evaluate_on), files)
        return diagnosis_of(*answer)

    def add(
        self,
        effect: str | Finding | None,
        log: Recording | None = None,
        *,
        axis: str | None = None,
        reference: Recording | None = None,
        evaluate_on: Recording | None = None,
        effects: Sequence[Path] = (),
    ) -> Refinement:
        """Adds an effect to the model of an axis: all added effects are estimated again together, and the error is
        measured on rows that were not fitted.

        Args:
            effect: Its identifier, or a finding of a diagnosis; None adds what the diagnosis finds, what should help most
                first, until nothing is worth adding.
            log: The log to explain; by default the log of the step before.
            axis: As `gx`, or a column; needed where the study has several.
            reference: A reference log of the same device; by default the one that was fitted.
            evaluate_on: The evaluation log; by default the last two fifths of `log`.
            effects: Effects of your own, one TOML file each.

        Returns:
            The axis with all steps.

        Raises:
            RefineError: It is in the model already, it cannot be corrected, or the axis was refined on other logs.
            EffectError: It is not known.
        """
        name = effect.effect if isinstance(effect, Finding) else effect
        files = [os.fspath(path) for path in effects]
        column = self._engine.add(name, engine_of(log), axis, engine_of(reference), engine_of(evaluate_on), files)
        return next(one for one in self.history if one.column == column)

    def undo(self, axis: str | None = None) -> str:
        """Takes the effect that was added last back; its identifier.

        Raises:
            RefineError: Nothing was added.
        """
        return self._engine.undo(axis)

    def export_image(self, sensor: str = "") -> bytes:
        """The image that a device takes, read back and tried before it is returned.

        Args:
            sensor: Name of the sensor, stored in the image.

        Raises:
            ImageError: The model makes no usable image.
        """
        return self._engine.export_image(sensor)

    def _json(self) -> Any:  # noqa: ANN401
        return json.loads(self._engine.json())

    def __repr__(self) -> str:
        grown = ", ".join(f"{one.column} {one.steps[-1].name}" for one in self.history if len(one.steps) > 1)
        return f"<Study of {', '.join(self.axes)}: {self.cost.terms} terms{'; ' + grown if grown else ''}>"

    def _repr_html_(self) -> str:
        fits = self.fits
        rows = [
            (one.column, len(one.steps), one.candidates, one.rows, _html.number(one.mse / one.mean_square), one.stopped)
            for one in fits
        ]
        header = ("axis", "terms", "candidates", "rows", "MSE / mean square", "stopped")
        return _html.card(
            "fitted to " + ", ".join(source.path for source in self.sources),
            _html.table(header, rows),
            *(one._repr_html_() for one in self.history),  # pyright: ignore[reportPrivateUsage]
        )


def _refinement(refinement: dict[str, Any], figure: dict[str, Any]) -> Refinement:
    steps: list[Step] = []
    for step in refinement["steps"]:
        added = step["added"]
        if added is not None:
            added = Added(added["effect"]["id"], finding_of(added["finding"]), added["realised_fall"])
        steps.append(
            Step(added, build(ModelErrors, step["errors"]), build(Left, step["left"]), build(Cost, step["cost"]))
        )
    logs = refinement["logs"]

    def source(name: str) -> Source | None:
        return build(Source, logs[name]) if logs.get(name) else None

    return Refinement(
        refinement["column"],
        build(Source, logs["log"]),
        source("reference"),
        source("evaluation"),
        logs["fitted_rows"],
        tuple(steps),
        build(Figure, figure),
    )


def _unit(column: str) -> str:
    return {"mps2": "m/s²", "rads": "rad/s"}.get(column.rsplit("_", 1)[-1], "")


def _warn_of(off: float | None) -> None:
    if off is not None:
        text = f"the log runs at another rate than the model: its lags are {100 * off:.1f} % off in time"
        warnings.warn(text, FosWarning, stacklevel=3)
