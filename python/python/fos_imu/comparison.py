"""A model against the measurements and against plain rivals, on rows that were not fitted."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _html
from ._results import build
from .figure import Figure

if TYPE_CHECKING:
    import pandas

Floats = npt.NDArray[np.float64]
Interval = tuple[float, float]


@dataclass(frozen=True)
class CoastError:
    """Error from own history after a time.

    Attributes:
        horizon_s: The time, s.
        mse: Mean square after exactly that time, unit².
        standard_error: Of that mean, coasts taken as independent.
        origins: Coasts that it is the mean of.
    """

    horizon_s: float
    mse: float
    standard_error: float
    origins: int


@dataclass(frozen=True)
class AllanValue:
    """Allan deviation of the residual in free run: averaging time, s, and deviation, unit of the axis."""

    tau_s: float
    deviation: float


@dataclass(frozen=True)
class RmsInterval:
    """RMS over windows, with its 90 % interval."""

    rms: float
    low: float
    high: float


@dataclass(frozen=True)
class UnaidedError:
    """Heading or position error after a time without aiding, over whole windows at rest.

    Attributes:
        window_s: The time, s.
        windows: Number of windows; below 3 there is no RMS.
        heading_rad: Heading error, rad; of a gyro axis, and of six axes together.
        position_m: Position error, m; of an accelerometer axis, and of six axes together.
    """

    window_s: float
    windows: int
    heading_rad: RmsInterval | None = None
    position_m: RmsInterval | None = None


@dataclass(frozen=True)
class ModelErrors:
    """Residual with one model; squares in the square of the axis' unit.

    Attributes:
        model: `model`, or the name of a rival.
        one_step_mse: Mean square of measured − predicted from measured history.
        coast: The same from own history, after 1, 10 and 60 s where the log is long enough.
        coast_whole_mse: The same over all rows, never restarted.
        slow_error_one_step: Variance of 1-s means, one-step; None where too short.
        slow_error_coast: Variance of 1-s means, coasting for at most 60 s.
        wide_error_one_step: Variance of the samples, one-step.
        wide_error_coast: Variance of the samples, coasting for at most 60 s.
        allan: Allan deviation when coasting, at 1, 10, 100 s.
        below_noise_floor: The one-step prediction error is below the limit of causal predictors: not to be trusted.
        cautions: Rows whose prediction came with a caution.
        unaided: Heading or position error after 1, 10, 60 and 600 s without aiding; empty in studies of earlier versions.
    """

    model: str
    one_step_mse: float
    coast: tuple[CoastError, ...]
    coast_whole_mse: float
    slow_error_one_step: float | None
    slow_error_coast: float | None
    wide_error_one_step: float
    wide_error_coast: float
    allan: tuple[AllanValue, ...]
    below_noise_floor: bool
    cautions: int
    unaided: tuple[UnaidedError, ...] = ()


@dataclass(frozen=True)
class Stretch:
    """A stretch where much is left.

    Attributes:
        begin_s: Begin, s as stamped.
        end_s: End, s as stamped.
        rms: RMS of the residual in free run, unit of the axis.
        mean: Of the same.
        ratio: `rms` over that of the median stretch.
        special: What of the logged is special there, most striking first.
    """

    begin_s: float
    end_s: float
    rms: float
    mean: float
    ratio: float
    special: tuple[str, ...]


@dataclass(frozen=True)
class ChannelTest:
    """Dependence of the residual on a channel.

    Attributes:
        gain: 2Δ ln L of a curve of the channel.
        score: The gain less the price of its coefficients.
        p: Chance of such a gain where nothing depends on anything.
    """

    gain: float
    score: float
    p: float


@dataclass(frozen=True)
class ChannelDependence:
    """Residual of an axis against one channel.

    Attributes:
        channel: Its column.
        unit: Its unit.
        curve: A curve of it against a constant.
        p_of_all: p of the curve after allowing for all channels.
    """

    channel: str
    unit: str
    curve: ChannelTest
    p_of_all: float


@dataclass(frozen=True)
class Dependence:
    """Residual of an axis against every logged channel.

    Attributes:
        block_s: Length of the blocks that means were taken over, s.
        blocks: How many have enough data.
        learnt: The noise was learnt from the rows that were fitted; else from the evaluated rows, with less certainty.
        channels: Every channel that changes, least likely first.
    """

    block_s: float
    blocks: int
    learnt: bool
    channels: tuple[ChannelDependence, ...]


@dataclass(frozen=True, eq=False)
class AxisComparison:
    """One axis against the measurements.

    Attributes:
        column: As `gx_rads`.
        unit: Its unit.
        rows: Rows at rest that were evaluated.
        noise_floor: Lower limit for any linear predictor, unit², and its 95 % interval.
        cautions: Reasons to distrust these numbers.
        errors: The rivals, then the model.
        worst: The stretches where the model fails worst.
        dependence: Residual against every logged channel; None if the log is too short.
        time_s: Timestamps of the evaluated rows, s, shape `(n,)`.
        measured: Measured error, offset included, unit of the axis, shape `(n,)`; NaN where it is not known.
        innovation: Measured − predicted one step ahead, shape `(n,)`.
        left: Measured − predicted from own history of at most 60 s, shape `(n,)`.
        draw: Draws `figures` as JSON, once they are requested.
    """

    column: str
    unit: str
    rows: int
    noise_floor: tuple[float, Interval] | None
    cautions: tuple[str, ...]
    errors: tuple[ModelErrors, ...]
    worst: tuple[Stretch, ...]
    dependence: Dependence | None
    time_s: Floats = field(repr=False, default_factory=lambda: np.zeros(0))
    measured: Floats = field(repr=False, default_factory=lambda: np.zeros(0))
    innovation: Floats = field(repr=False, default_factory=lambda: np.zeros(0))
    left: Floats = field(repr=False, default_factory=lambda: np.zeros(0))
    draw: Callable[[], str] | None = field(repr=False, default=None)

    @functools.cached_property
    def figures(self) -> Mapping[str, Figure]:
        """Over time, residual, autocorrelation, spectrum, Allan deviation, dependence: as far as the log is long enough."""
        figures = json.loads(self.draw()) if self.draw else {}
        return {name: build(Figure, figure) for name, figure in figures.items()}

    def __getstate__(self) -> dict[str, object]:
        """For pickle: the figures are drawn, because the engine's rows are not stored."""
        return {**self.__dict__, "figures": self.figures, "draw": None}

    @property
    def model(self) -> ModelErrors:
        """The errors of the model, rivals apart."""
        return self.errors[-1]

    @property
    def predicted(self) -> Floats:
        """Predicted error while coasting for at most 60 s, unit of the axis, shape `(n,)`."""
        return self.measured - self.left

    def to_pandas(self) -> pandas.DataFrame:
        """One row a model: its errors, squares in the square of the unit."""
        import pandas

        def row(errors: ModelErrors) -> dict[str, object]:
            return {
                "model": errors.model,
                "one_step_mse": errors.one_step_mse,
                **{f"coast_{coast.horizon_s:.0f}_s_mse": coast.mse for coast in errors.coast},
                "coast_whole_mse": errors.coast_whole_mse,
                "slow_error_one_step": errors.slow_error_one_step,
                "slow_error_coast": errors.slow_error_coast,
                "wide_error_one_step": errors.wide_error_one_step,
                "wide_error_coast": errors.wide_error_coast,
                **{
                    f"{name}_after_{one.window_s:.0f}_s": error.rms
                    for one in errors.unaided
                    for name, error in (("heading_rad", one.heading_rad), ("position_m", one.position_m))
                    if error is not None
                },
                "cautions": errors.cautions,
            }

        return pandas.DataFrame([row(errors) for errors in self.errors])

    def _repr_html_(self) -> str:
        number = _html.number
        horizons = [coast.horizon_s for coast in self.errors[-1].coast]
        header = ["", "one-step", *(f"coast {horizon:.0f} s" for horizon in horizons), "slow, coast", "wide, coast"]

        def row(errors: ModelErrors) -> list[object]:
            at = {coast.horizon_s: coast.mse for coast in errors.coast}
            squares = [errors.one_step_mse, *(at.get(horizon) for horizon in horizons)]
            squares += [errors.slow_error_coast, errors.wide_error_coast]
            return [errors.model, *(number(None if mse is None else mse**0.5) for mse in squares)]

        follows = [one for one in self.dependence.channels if one.p_of_all < 0.05] if self.dependence else []
        notes = [f"the residual follows {one.channel} (p = {one.p_of_all:.2g})" for one in follows[:4]]
        if self.model.below_noise_floor:
            notes.append("the one-step prediction error is below the noise floor: not to be trusted")
        worst = [
            f"worst from {s.begin_s:.1f} to {s.end_s:.1f} s, {s.ratio:.1f} times the usual" for s in self.worst[:1]
        ]
        return _html.card(
            f"{self.column}: {self.rows} rows at rest that were not fitted",
            _html.paragraph(f"roots of mean squares, {self.unit}"),
            _html.table(header, [row(errors) for errors in self.errors]),
            *(_html.paragraph(note, _html.BAD) for note in notes),
            *(_html.paragraph(text) for text in worst),
            *_html.pictures(self.figures.get("over_time"), self.figures.get("residual")),
        )


@dataclass(frozen=True)
class Comparison:
    """A model against the measurements.

    Attributes:
        evaluated_s: First and last time stamp of the evaluated rows, s.
        axes: The axes of the model.
        strapdown: Errors of a strapdown of all six axes, by length of the windows: before the model and after it. Empty
            unless the model has all six.
    """

    evaluated_s: Interval
    axes: tuple[AxisComparison, ...]
    strapdown: tuple[tuple[UnaidedError, UnaidedError], ...] = ()

    def __getitem__(self, axis: str) -> AxisComparison:
        """The axis of this column, or of its first part: `gx`."""
        for one in self.axes:
            if axis in (one.column, one.column.split("_")[0]):
                return one
        raise KeyError(axis)

    def __iter__(self) -> Iterator[AxisComparison]:
        return iter(self.axes)

    def to_pandas(self) -> pandas.DataFrame:
        """One row an axis and model."""
        import pandas

        return pandas.concat({one.column: one.to_pandas() for one in self.axes}, names=["axis", None])

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() for one in self.axes)  # pyright: ignore[reportPrivateUsage]
