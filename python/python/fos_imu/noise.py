"""White noise, bias instability and random walk of a log at rest."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _engine, _html
from ._results import build
from .figure import Figure
from .recording import Recording, engine_of

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Level:
    """What a log tells of one level.

    Attributes:
        value: The likeliest value; None where none at all is as likely.
        low: Lower end of the 90 % interval; None where there may be none of it.
        high: Upper end of it, which is also the 95 % limit where there is no lower end.
        unit: Unit of all three, in ASCII.
    """

    value: float | None
    low: float | None
    high: float
    unit: str = ""

    def __str__(self) -> str:
        if self.value is None:
            return f"at most {self.high:.3g} {self.unit}"
        return f"{self.value:.3g} ({0.0 if self.low is None else self.low:.3g} … {self.high:.3g}) {self.unit}"


@dataclass(frozen=True)
class AllanPoint:
    """Overlapping Allan deviation at one averaging time.

    Attributes:
        tau_s: Averaging time, s.
        deviation: Unit of the axis.
        low: Lower end of the 95 % interval.
        high: Upper end of it.
        degrees_of_freedom: Behind the interval.
    """

    tau_s: float
    deviation: float
    low: float
    high: float
    degrees_of_freedom: float


@dataclass(frozen=True)
class ThermalDrift:
    """Drift with temperature that was removed before the noise was estimated.

    Attributes:
        range_c: Lowest and highest temperature, °C.
        rms: RMS of the drift about its mean, unit of the axis.
    """

    range_c: tuple[float, float]
    rms: float


@dataclass(frozen=True)
class GaussMarkovNoise:
    """White noise and a first-order Gauss–Markov process.

    Attributes:
        white: N beside the process.
        deviation: Standard deviation of the bias.
        tau_s: Correlation time, s.
        gain: Decrease of −2 ln L against N, B and K, after a penalty for parameters.
    """

    white: Level
    deviation: Level
    tau_s: Level
    gain: float


@dataclass(frozen=True)
class FilterNoise:
    """Noise of a Kalman filter with one bias state: next bias = transition · bias + noise of bias_variance.

    Attributes:
        interval_s: Update interval, s: one sample of the log.
        white: N, unit·√s.
        white_variance: Variance of the white noise of one update, N²/interval, unit².
        deviation: Standard deviation of the bias; None for a random walk.
        tau_s: Correlation time, s; None for a random walk.
        walk: K, unit/√s; None for a Gauss–Markov process.
        transition: Factor of the bias from one update to the next.
        bias_variance: Variance added to the bias in each update, unit²; None if it is not identifiable.
        absent: Reason why values are None: hidden_by_step, walk_not_seen.
    """

    interval_s: float
    white: float | None = None
    white_variance: float | None = None
    deviation: float | None = None
    tau_s: float | None = None
    walk: float | None = None
    transition: float | None = None
    bias_variance: float | None = None
    absent: str | None = None


@dataclass(frozen=True)
class AxisNoise:
    """Noise of one axis at rest. Motion, knocks and outliers are excluded.

    Attributes:
        column: The axis.
        unit: Its unit.
        seconds: Time at rest that it is of, s.
        span_s: From the first to the last sample at rest, s.
        left_out: Number of outliers.
        white: N: the mean over t seconds has variance N²/t.
        flicker: B, bias instability: the Allan deviation is flat at 0.664·B.
        walk: K, rate random walk: the bias moves by K·√t in t seconds.
        walk_needs_s: How long a log would have to be to tell more of a walk that was not seen, s.
        allan: Allan deviation; none of its differences reaches over a gap or a motion.
        step: Step of the converter where it hides the noise: N, B and K are then limits.
        thermal_drift: Drift with the logged temperature, estimated together with N, B and K and part of none of them.
        walk_within_20_percent_s: Time at rest, s, after which a walk that was seen is expected within ±20 % (90 %).
        gauss_markov: White noise and a Gauss–Markov process, where they describe the axis better than N, B and K.
        filter: Noise of a Kalman filter that is updated with every sample.
        figure: Allan deviation as measured, and of N, B and K.
    """

    column: str
    unit: str
    seconds: float
    span_s: float
    left_out: int
    white: Level
    flicker: Level
    walk: Level
    walk_needs_s: float | None
    allan: tuple[AllanPoint, ...]
    step: float | None = None
    thermal_drift: ThermalDrift | None = None
    walk_within_20_percent_s: float | None = None
    gauss_markov: GaussMarkovNoise | None = None
    filter: FilterNoise | None = None
    figure: Figure | None = field(default=None, repr=False)

    def to_pandas(self) -> pandas.DataFrame:
        """The Allan deviation, one row an averaging time."""
        import pandas

        return pandas.DataFrame([vars(point) for point in self.allan])

    def _repr_html_(self) -> str:
        rows = [("N", self.white), ("B", self.flicker), ("K", self.walk)]
        notes: list[str] = []
        if self.walk_needs_s is not None:
            notes.append(f"too short for K; about {self.walk_needs_s / 60:.0f} min would show half as much")
        if self.walk_within_20_percent_s is not None:
            notes.append(f"{self.walk_within_20_percent_s / 60:.0f} min at rest are expected to give K within ±20 %")
        if self.thermal_drift is not None:
            notes.append(
                f"a drift with temperature of {self.thermal_drift.rms:.3g} {self.unit} RMS is not part of B and K"
            )
        return _html.card(
            f"{self.column}: {self.seconds:.0f} s at rest",
            _html.table(("", "likeliest, 90 % interval"), rows),
            *(_html.paragraph(note) for note in notes),
            *_html.pictures(self.figure),
        )


@dataclass(frozen=True)
class Noise:
    """Noise of the axes of a log."""

    axes: tuple[AxisNoise, ...]

    def __getitem__(self, axis: str) -> AxisNoise:
        """The axis of this column, or of its first part: `gx`."""
        for one in self.axes:
            if axis in (one.column, one.column.split("_")[0]):
                return one
        raise KeyError(axis)

    def __iter__(self) -> Iterator[AxisNoise]:
        return iter(self.axes)

    def __len__(self) -> int:
        return len(self.axes)

    def to_pandas(self) -> pandas.DataFrame:
        """One row an axis and level: value, interval, unit."""
        import pandas

        def row(axis: AxisNoise, name: str, level: Level) -> dict[str, Any]:
            return {"axis": axis.column, "level": name, **vars(level)}

        named = (("N", "white"), ("B", "flicker"), ("K", "walk"))
        return pandas.DataFrame([row(axis, name, getattr(axis, of)) for axis in self.axes for name, of in named])

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() for one in self.axes)  # pyright: ignore[reportPrivateUsage]


def noise(log: Recording, *, axes: Sequence[str] | str | None = None) -> Noise:
    """The noise of a log of a unit lying still.

    Args:
        log: The longer the better: three hours tell the random walk of most parts.
        axes: As `gx`, a column, or several; all that there are if not given.

    Raises:
        NoiseError: Too little at rest, or an axis that never changes.
        RecordingError: A column is missing.
    """
    chosen = [axes] if isinstance(axes, str) else axes
    found = json.loads(_engine.noise(engine_of(log), None if chosen is None else list(chosen)))

    def axis(data: dict[str, Any]) -> AxisNoise:
        levels = zip(("white", "flicker", "walk"), data["units"], strict=True)
        return build(
            AxisNoise,
            {
                **data["noise"],
                "figure": data["figure"],
                **{name: {**data["noise"][name], "unit": unit} for name, unit in levels},
            },
        )

    return Noise(tuple(axis(one) for one in found))


@dataclass(frozen=True)
class NoiseFiles:
    """The noise of a log as the files of other programs have it, as text.

    Attributes:
        imu_yaml: For Kalibr and OpenVINS, which both read this file.
        orb_slam3: Lines for the settings of ORB-SLAM3.
        vins: Lines for the configuration of VINS-Mono and VINS-Fusion.
    """

    imu_yaml: str
    orb_slam3: str
    vins: str


def noise_files(log: Recording, *, rostopic: str = "/imu0") -> NoiseFiles:
    """The noise of a log for Kalibr, OpenVINS, ORB-SLAM3 and VINS: of three axes the one that has the most.

    Args:
        log: Of a unit lying still, all six axes.
        rostopic: The topic of the sensor, for Kalibr.

    Raises:
        NoiseError: Not all six axes, too little at rest.
    """
    return NoiseFiles(*_engine.imu_yaml(engine_of(log), rostopic))
