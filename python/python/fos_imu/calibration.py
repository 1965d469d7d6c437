"""Bias, sensitivity and cross-axis from a log of hand-turned orientations, or of a turntable."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _engine, _html
from ._results import build
from .errors import CalibrateError
from .figure import Figure
from .recording import Floats, Recording, engine_of

if TYPE_CHECKING:
    import pandas

MG_MPS2 = 9.80665e-3
"""A thousandth of standard gravity, m/s²."""


@dataclass(frozen=True)
class Parameter:
    """A number of a calibration.

    Attributes:
        id: As `accelerometer.bias.x`.
        label: As people call it.
        value: In its unit; 1 for a nominal sensitivity.
        half_width: Half the width of the 95 % interval, in the same unit.
        unit: Empty for a ratio.
        determined: well, weakly (an orientation is missing), not_by_this_log (the interval is that of typical parts).
        text: Value and interval as data sheets write them, in mg, %, °/s.
    """

    id: str
    label: str
    value: float
    half_width: float
    unit: str
    determined: str
    text: str

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the 95 % interval."""
        return self.value - self.half_width, self.value + self.half_width

    def __str__(self) -> str:
        return f"{self.label}: {self.text}"


@dataclass(frozen=True)
class Correction:
    """Correction of three axes: matrix · (values - bias).

    Attributes:
        matrix: Inverse of sensitivity and cross-axis, shape `(3, 3)`.
        bias: In the unit of the log, shape `(3,)`.
    """

    matrix: tuple[tuple[float, ...], ...]
    bias: tuple[float, ...]

    def __call__(self, values: npt.ArrayLike) -> Floats:
        """Corrected values of shape `(n, 3)`, m/s² or rad/s."""
        raw = np.asarray(values, float)
        if raw.ndim != 2 or raw.shape[1] != 3:
            raise CalibrateError(f"values of shape {raw.shape}", remedy="give x, y and z as columns: shape (n, 3)")
        return (raw - np.array(self.bias)) @ np.array(self.matrix).T


@dataclass(frozen=True)
class Rest:
    """A stretch at rest, in one orientation.

    Attributes:
        start_s: By the time of the log, s.
        duration_s: How long it lasts, s.
        temperature_c: Mean temperature, °C; None where none is logged.
        up: Direction that points up, in the axes of the sensor.
        residual_mps2: Corrected |a| - g, m/s².
        deviation_mps2: Its expected standard deviation, m/s².
        excluded: Reason why the estimate does not use it; None if it does.
    """

    start_s: float
    duration_s: float
    temperature_c: float | None
    up: tuple[float, ...]
    residual_mps2: float
    deviation_mps2: float
    excluded: str | None


@dataclass(frozen=True)
class Next:
    """The orientation to record next.

    Attributes:
        instruction: In words.
        parameter: The parameter with the widest interval now.
        worst_mps2: Half the width of that interval now, and the widest after 3 s in this orientation, m/s² at 1 g.
    """

    instruction: str
    parameter: str
    worst_mps2: tuple[float, ...]


def _table(parameters: Sequence[Parameter]) -> str:
    return _html.table(("", "value, 95 % interval"), [(one.label, one.text) for one in parameters])


def _frame(parameters: Sequence[Parameter]) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame([vars(one) for one in parameters]).set_index("id")


@dataclass(frozen=True)
class Calibration:
    """Calibration by hand: gravity is the reference of the accelerometer, and its turned direction that of the gyro.

    Attributes:
        parameters: All estimated numbers.
        accelerometer: Correction of the accelerometer.
        gyro: Correction of the gyro, in the frame of the accelerometer; None where it was not estimated (see cautions).
        gravity_mps2: Gravity that was used, m/s².
        reference_c: Temperature at which the corrections hold, °C; None where none is logged.
        rests: All stretches at rest, those that were excluded too.
        orientations: Distinct orientations among the used rests; with fewer than 10 the residual shows nothing of the fit.
        unseen: Faces that no rest comes near to.
        rms_mps2: RMS of |a| - g at rest, m/s²: corrected, and before; None for a log in counts.
        rms_deg: RMS error of the direction of gravity after a turn, °: corrected, and before.
        worst_mps2: The largest half-width of bias, sensitivity and cross-axis, m/s² at 1 g.
        next: The orientation that narrows it most.
        is_accurate: True if the accuracy that was asked for is reached; None if none was.
        plan: Further rests until it is; None if 12 more do not reach it.
        cautions: Reasons to distrust parts of it.
        files: Text for other programs: px4, ardupilot, kalibr, imu_tk_acc, imu_tk_gyro, as far as they can hold it.
        figure: Residual of each rest, with the range in which 95 % are expected.
    """

    parameters: tuple[Parameter, ...]
    accelerometer: Correction
    gyro: Correction | None
    gravity_mps2: float
    reference_c: float | None
    rests: tuple[Rest, ...]
    orientations: int
    unseen: tuple[str, ...]
    rms_mps2: tuple[float | None, ...]
    rms_deg: tuple[float | None, ...]
    worst_mps2: float
    next: Next
    is_accurate: bool | None
    plan: tuple[str, ...] | None
    cautions: tuple[str, ...]
    files: Mapping[str, str] = field(repr=False)
    figure: Figure | None = field(default=None, repr=False)

    def __getitem__(self, id: str) -> Parameter:
        """The parameter of this id, as `accelerometer.bias.x`."""
        return _of_id(self.parameters, id)

    def to_pandas(self) -> pandas.DataFrame:
        """One row a parameter, by its id."""
        return _frame(self.parameters)

    def _repr_html_(self) -> str:
        after, before = (None if rms is None else rms / MG_MPS2 for rms in self.rms_mps2)
        now, then = (size / MG_MPS2 for size in self.next.worst_mps2)
        rests = sum(one.excluded is None for one in self.rests)
        return _html.card(
            f"Calibration from {rests} rests in {self.orientations} orientations",
            _html.paragraph(f"|a| - g at rest: {_html.number(before)} before, {_html.number(after)} mg RMS corrected"),
            _table(self.parameters),
            *(_html.paragraph(caution, _html.BAD) for caution in self.cautions),
            _html.paragraph(
                f"next: {self.next.instruction}, 3 s: the widest interval ({self.next.parameter}) narrows from "
                f"± {now:.2g} to ± {then:.2g} mg at 1 g"
            ),
            *_html.pictures(self.figure),
        )


@dataclass(frozen=True)
class Plateau:
    """A stretch of constant rate.

    Attributes:
        start_s: By the time of the log, s.
        duration_s: How long it lasts, s.
        rate_rads: Stated rate, rad/s.
        axis: Direction of the rate in the axes of the sensor.
        residual: Corrected |rate| against the stated one, as a share.
        excluded: True for an outlier.
    """

    start_s: float
    duration_s: float
    rate_rads: float
    axis: tuple[float, ...]
    residual: float
    excluded: bool


@dataclass(frozen=True)
class TurntableCalibration:
    """Calibration of a gyro on a turntable. An error of the stated rate is an error of all three sensitivities.

    Attributes:
        parameters: All estimated numbers.
        gyro: Correction of the gyro.
        rates_rads: Stated rates, rad/s.
        plateaus: Stretches of constant rate.
        rms: RMS of |rate| against the stated one, as a share: corrected, and before; None for a log in counts.
    """

    parameters: tuple[Parameter, ...]
    gyro: Correction
    rates_rads: tuple[float, ...]
    plateaus: tuple[Plateau, ...]
    rms: tuple[float | None, ...]

    def __getitem__(self, id: str) -> Parameter:
        """The parameter of this id, as `gyro.sensitivity.z`."""
        return _of_id(self.parameters, id)

    def to_pandas(self) -> pandas.DataFrame:
        """One row a parameter, by its id."""
        return _frame(self.parameters)

    def _repr_html_(self) -> str:
        after, before = self.rms
        used = sum(not one.excluded for one in self.plateaus)
        error = f"|rate| against the stated rate: {_html.percent(before)} before, {_html.percent(after)} RMS corrected"
        return _html.card(f"Calibration from {used} plateaus", _html.paragraph(error), _table(self.parameters))


def _of_id(parameters: Sequence[Parameter], id: str) -> Parameter:
    for one in parameters:
        if one.id == id:
            return one
    raise KeyError(id)


def calibrate(
    log: Recording,
    *,
    latitude_deg: float | None = None,
    height_m: float = 0.0,
    accuracy_mg: float | None = None,
) -> Calibration:
    """Bias, sensitivity and cross-axis of accelerometer and gyro from hand-turned orientations.

    Args:
        log: Of a device that lay in 12 orientations or more, for 3 s each, and was turned in between. Columns in counts
            (`ax_cnt`) need no scale.
        latitude_deg: Of the place, °. Without it standard gravity is assumed, which is wrong by up to 0.27 %.
        height_m: Of the place above sea level, m.
        accuracy_mg: Accuracy that is needed at 1 g, mg; the result says whether it is reached, and which rests would do.

    Raises:
        CalibrateError: The orientations do not determine the calibration; the message says which to record.
    """
    place = None if latitude_deg is None else (latitude_deg, height_m)
    accuracy = None if accuracy_mg is None else accuracy_mg * MG_MPS2
    found: dict[str, Any] = json.loads(_engine.calibrate(engine_of(log), place, accuracy))
    return build(Calibration, found)


def calibrate_on_turntable(log: Recording, *, rates_rads: Sequence[float]) -> TurntableCalibration:
    """Bias, sensitivity and cross-axis of a gyro from a turntable.

    Args:
        log: With plateaus of these rates about several axes.
        rates_rads: Rates of the turntable, rad/s, without sign.

    Raises:
        CalibrateError: The plateaus do not determine the calibration.
    """
    found: dict[str, Any] = json.loads(_engine.calibrate_on_turntable(engine_of(log), list(rates_rads)))
    return build(TurntableCalibration, found)
