"""From one device to a fleet: a row for each device, the populations behind the rows, odd devices."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from . import _engine, _html
from ._results import build
from .diagnosis import NoiseLevels
from .errors import FleetError
from .recording import Path, Recording, engine_of

if TYPE_CHECKING:
    import pandas

Values: TypeAlias = tuple[float, ...]
Matrix: TypeAlias = tuple[Values, ...]


@dataclass(frozen=True)
class Estimate:
    """Coefficients of an axis: its bias at 25 °C, and one for each regressor that its log tells.

    Attributes:
        names: `bias`, or the regressor as it was asked for, n of them.
        values: In the unit of the axis (SI) per unit of the regressor, shape `(n,)`.
        covariance: Of their errors, shape `(n, n)`.
    """

    names: tuple[str, ...]
    values: Values
    covariance: Matrix


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was found on a unit, and the share of the error of its band that should go with it, 0 … 1."""

    effect: str
    predicted_reduction: float


@dataclass(frozen=True)
class AxisDiagnosis:
    """What a diagnosis says of an axis.

    Attributes:
        verdict: As of `Diagnosis`.
        effects: Missing effects that are conclusive.
    """

    verdict: Literal["missing", "nothing_missing", "unexplained", "not_enough_data"]
    effects: tuple[FoundEffect, ...]


@dataclass(frozen=True)
class AxisRow:
    """An axis of a unit.

    Attributes:
        column: As `gx_rads`.
        coefficients: What its log tells of them.
        noise: That goes with them, in the unit of the axis.
        seconds: Time at rest that it is of, s.
        diagnosis: What a diagnosis says; None where none was asked for.
    """

    column: str
    coefficients: Estimate
    noise: NoiseLevels
    seconds: float
    diagnosis: AxisDiagnosis | None = None


@dataclass(frozen=True)
class LogSummary:
    """What was read of a unit.

    Attributes:
        rows: Samples.
        seconds: From the first to the last, s.
        rate_hz: True sample rate, Hz.
        temperature_c: Lowest and highest, °C; None without a thermometer.
    """

    rows: int
    seconds: float
    rate_hz: float
    temperature_c: tuple[float, float] | None


@dataclass(frozen=True)
class UnitRow:
    """A device with the estimates from its log; in `failed`, why they are missing or incomplete.

    Attributes:
        unit: Its name.
        part: The part, as `bmi270`; empty: all are of one.
        lot: Its lot; None where it is not known.
        program: What made the row.
        sha256: Digest of the log, hexadecimal; of several that of their digests, a line each; empty where none could be read.
        axes: The axes that could be estimated.
        log: What was read; None where the log could not be.
        failed: Why the log, or an axis of it, cannot be used.
    """

    unit: str
    part: str
    program: str
    sha256: str
    axes: tuple[AxisRow, ...]
    lot: str | None = None
    log: LogSummary | None = None
    failed: tuple[str, ...] = ()
    _text: str = field(default="", repr=False, compare=False)

    @classmethod
    def from_json(cls, text: str) -> UnitRow:
        """The row of `to_json()`, here or on another machine.

        Raises:
            FleetError: It is none.
        """
        try:
            return build(cls, {**json.loads(text), "_text": text})
        except (TypeError, ValueError, KeyError) as error:
            raise FleetError(
                f"{text[:60]!r} … is not the row of a device: {error}",
                remedy="rows are what `unit_row` gives, or its `to_json()`",
            ) from None

    def to_json(self) -> str:
        """All of it, to the last bit; one line."""
        return self._text

    def to_pandas(self) -> pandas.DataFrame:
        """One row an axis and coefficient: value and standard error, SI."""
        import pandas

        return pandas.DataFrame(
            [
                {
                    "unit": self.unit,
                    "part": self.part,
                    "lot": self.lot,
                    "axis": axis.column,
                    "coefficient": name,
                    "value": axis.coefficients.values[place],
                    "standard_error": axis.coefficients.covariance[place][place] ** 0.5,
                }
                for axis in self.axes
                for place, name in enumerate(axis.coefficients.names)
            ],
            columns=["unit", "part", "lot", "axis", "coefficient", "value", "standard_error"],
        )

    def _repr_html_(self) -> str:
        rows = [
            (axis.column, name, _html.number(value), _html.number(axis.coefficients.covariance[place][place] ** 0.5))
            for axis in self.axes
            for place, (name, value) in enumerate(zip(axis.coefficients.names, axis.coefficients.values, strict=True))
        ]
        return _html.card(
            ", ".join(part for part in (self.unit, self.part, self.lot) if part),
            *(_html.paragraph(reason, _html.BAD) for reason in self.failed),
            _html.table(("axis", "coefficient", "value, SI", "standard error"), rows),
        )


@dataclass(frozen=True)
class Scatter:
    """How a coefficient scatters: standard deviations, unit of the axis (SI) per unit of the regressor.

    Attributes:
        units: Between units of a lot.
        units_interval: 90 %.
        lots: Between lots.
        lots_interval: 90 %.
        lots_alike: How often lots that do not differ would look so different; None with fewer than two lots.
        measurement: Error of a log, root mean square.
    """

    units: float
    units_interval: tuple[float, float]
    lots: float
    lots_interval: tuple[float, float]
    lots_alike: float | None
    measurement: float


@dataclass(frozen=True)
class Lot:
    """Estimates of a lot.

    Attributes:
        name: Empty for units whose lot is not known.
        units: How many.
        mean: Of each coefficient, SI, shape `(n,)`.
        covariance: Of the mean, shape `(n, n)`.
        mean_interval: 90 % of each mean, by Student's t.
        unit_interval: Of each coefficient, where nine of ten units of the lot lie.
    """

    name: str
    units: int
    mean: Values
    covariance: Matrix
    mean_interval: tuple[tuple[float, float], ...]
    unit_interval: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Population:
    """What the units of a part have in common on an axis; n coefficients, SI.

    Attributes:
        names: The coefficients, in the order of everything below.
        units: How many units.
        mean: Of the part, shape `(n,)`.
        mean_covariance: Of that mean, shape `(n, n)`.
        mean_interval: 90 % of each mean, by Student's t.
        unit_interval: Of each coefficient, where nine of ten units of a lot that is not known lie.
        between_lots: Covariance between lots, shape `(n, n)`.
        between_units: Covariance between units of a lot, shape `(n, n)`.
        scatter: Of each coefficient.
        lots: Estimates of each lot.
    """

    names: tuple[str, ...]
    units: int
    mean: Values
    mean_covariance: Matrix
    mean_interval: tuple[tuple[float, float], ...]
    unit_interval: tuple[tuple[float, float], ...]
    between_lots: Matrix
    between_units: Matrix
    scatter: tuple[Scatter, ...]
    lots: tuple[Lot, ...]


@dataclass(frozen=True)
class EffectShare:
    """An effect in a population.

    Attributes:
        effect: Its identifier.
        units: Units that have it, and units that were asked.
        mean_reduction: Fall of the error if every model had it, mean over all units, 0 … 1.
        device: What it costs on the device, in words.
    """

    effect: str
    units: tuple[int, int]
    mean_reduction: float
    device: str


@dataclass(frozen=True)
class AxisSummary:
    """An axis of a part.

    Attributes:
        column: As `gx_rads`.
        population: None where too few units tell a coefficient.
        without: Why there is none.
        median_noise: White noise, flicker, random walk of the median unit, in the unit of the axis.
        effects: What diagnoses found.
    """

    column: str
    population: Population | None
    median_noise: tuple[float, float, float]
    without: str | None = None
    effects: tuple[EffectShare, ...] = ()


@dataclass(frozen=True)
class Distance:
    """How far a unit is from its population.

    Attributes:
        coefficients: Coefficients that were compared.
        p_value: Probability that a unit that belongs is further away in any of them.
        most: The coefficient that is least probable by itself.
        by: Its deviation from the population without this unit, in standard deviations: Student's t.
        freedom: Degrees of freedom of that t.
    """

    coefficients: int
    p_value: float
    most: str
    by: float
    freedom: float


@dataclass(frozen=True)
class OddUnit:
    """An odd device.

    Attributes:
        unit: Its name.
        lot: Its lot.
        column: The axis that shows it best.
        distance: How far it is there.
        p_value: Probability that a unit that belongs is so far in any axis.
    """

    unit: str
    lot: str | None
    column: str
    distance: Distance
    p_value: float


@dataclass(frozen=True)
class PartSummary:
    """A part.

    Attributes:
        part: Its name.
        axes: Its axes.
        odd: Its odd devices, the furthest first.
        units_needed: Units needed to find an odd one, where there are fewer: that none is odd is then not conclusive.
            None if there are enough.
    """

    part: str
    axes: tuple[AxisSummary, ...]
    odd: tuple[OddUnit, ...]
    units_needed: int | None = None


@dataclass(frozen=True)
class DuplicateUnit:
    """A unit whose log is that of another one, bit by bit; it counts once."""

    part: str
    unit: str
    same_as: str


@dataclass(frozen=True)
class FailedUnit:
    """A unit of which nothing, or not everything, could be told, and why."""

    unit: str
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Fleet:
    """What a fleet comes to.

    Attributes:
        units: Units that were asked.
        parts: Each part, by name.
        failed: Units of which something could not be told.
        duplicates: Units whose log is that of another one of their part.
    """

    units: int
    parts: tuple[PartSummary, ...]
    failed: tuple[FailedUnit, ...]
    _found: _engine.Fleet = field(repr=False, compare=False)
    duplicates: tuple[DuplicateUnit, ...] = ()

    def save(self, path: Path, *, rows: Rows | None = None) -> None:
        """Writes it as `fos fleet -o` does, byte for byte of the same rows, and atomically.

        Args:
            path: Of the population.
            rows: Those that it is of, again: kept beside it, at `path` with `.rows` behind it, where `fos fleet report`,
                `fleet export` and the workbench look for them.

        Raises:
            FileError: A file cannot be written.
            FleetError: Rows of other units.
        """
        self._found.save(os.fspath(path), None if rows is None else list(_texts(rows)))

    def to_pandas(self) -> pandas.DataFrame:
        """One row a part, axis and coefficient: mean, standard deviations between units and between lots, SI."""
        import pandas

        return pandas.DataFrame(self._table(), columns=[*_COLUMNS])

    def _about_odd(self, some: bool) -> str:
        if some:
            return "odd devices"
        needed = max((part.units_needed or 0 for part in self.parts), default=0)
        return (
            f"odd units: not conclusive; at least {needed} units are needed"
            if needed
            else "no unit is unlike the others"
        )

    def _table(self) -> list[tuple[Any, ...]]:
        return [
            (
                part.part,
                axis.column,
                name,
                found.units,
                found.mean[place],
                scatter.units,
                scatter.lots,
                scatter.measurement,
            )
            for part in self.parts
            for axis in part.axes
            if (found := axis.population) is not None
            for place, (name, scatter) in enumerate(zip(found.names, found.scatter, strict=True))
        ]

    def _repr_html_(self) -> str:
        rows = [(*row[:4], *(_html.number(value) for value in row[4:])) for row in self._table()]
        odd = [
            (
                one.unit,
                one.lot or "",
                one.column,
                one.distance.most,
                _html.number(one.distance.by),
                f"{one.p_value:.1e}",
            )
            for part in self.parts
            for one in part.odd
        ]
        reasons = [f"{one.unit}: {reason}" for one in self.failed[:10] for reason in one.reasons]
        return _html.card(
            f"{self.units} units, {len(self.failed)} of them with something that could not be told",
            _html.table(_COLUMNS, rows),
            *(
                _html.paragraph(f"{one.same_as} and {one.unit} are the same log: counted once")
                for one in self.duplicates
            ),
            _html.paragraph(self._about_odd(bool(odd))),
            _html.table(("unit", "lot", "axis", "by", "standard deviations", "p"), odd) if odd else "",
            *(_html.paragraph(reason, _html.BAD) for reason in reasons),
        )


_COLUMNS = ("part", "axis", "coefficient", "units", "mean", "between units", "between lots", "error of a log")

Rows: TypeAlias = "Iterable[UnitRow | str] | pandas.DataFrame"


def unit_row(
    log: Path | Recording | Sequence[Path] | Sequence[Recording],
    *,
    unit: str | None = None,
    part: str = "",
    lot: str | None = None,
    regressors: Sequence[str] = ("temp_c",),
    diagnose: bool = False,
    effects: Sequence[Path] = (),
    largest_bytes: int | None = None,
    map: Sequence[str] = (),
    rate_hz: float | None = None,
    format: str | None = None,
    topic: str | None = None,
    strict: bool = False,
    keep_moved: bool = False,
    shown_as: Sequence[str] = (),
) -> UnitRow:
    """A unit in one row: of each axis bias and coefficients with their covariance, from a log at rest or several.

    What is wrong with a log is in `failed` of the row, and no exception. Several logs count as one that goes on; what cannot
    be read of them is excluded.

    Args:
        log: A file, or a recording, which is taken as it was read; or several files or several recordings.
        unit: Its name, one of a kind in its part; the stem of the first file if not given.
        part: As `bmi270`; units of different parts have nothing in common.
        lot: Its lot.
        regressors: What the error may depend on, beside a bias at 25 °C: `temp_c * temp_c`, `temp_c:lowpass(60)`.
        diagnose: Say which effects every axis has; takes some seconds each.
        effects: Files of effects of your own.
        largest_bytes: A larger file is not read, and its row says so.
        map: As of `read`; this and what follows for a file alone.
        rate_hz: As of `read`, Hz.
        format: As of `read`.
        topic: As of `read`.
        strict: As of `read`.
        keep_moved: As of `read`.
        shown_as: What reasons in `failed` call the files, where they are copies of others.

    Raises:
        FleetError: A regressor that cannot be read, or that is given twice.
        RecordingError: A map or a format that cannot be.
        EffectError: A file that is no effect.
    """
    files = [os.fspath(path) for path in effects]
    logs = [log] if isinstance(log, (str, os.PathLike, Recording)) else list(log)
    recordings = [one for one in logs if isinstance(one, Recording)]
    if not logs or len(recordings) not in (0, len(logs)):
        raise FleetError(
            "no logs of a unit" if not logs else "files and recordings of a unit at once",
            remedy="a file or several, a recording or several",
        )
    if recordings:
        name = PurePath(recordings[0].sources[0].path).stem if unit is None else unit
        engines = [engine_of(one) for one in recordings]
        return UnitRow.from_json(_engine.recording_row(engines, (name, part, lot), list(regressors), diagnose, files))
    paths = [os.fspath(one) for one in logs if not isinstance(one, Recording)]
    named = (PurePath(paths[0]).stem if unit is None else unit, part, lot)
    reading = (largest_bytes, list(map), rate_hz, format, topic, strict, keep_moved)
    return UnitRow.from_json(
        _engine.unit_row(paths, list(shown_as), named, list(regressors), diagnose, files, *reading)
    )


def population(rows: Rows, *, effects: Sequence[Path] = ()) -> Fleet:
    """The populations of the parts that rows are of. In whatever order rows come, the same rows give the same bits.

    Args:
        rows: What `unit_row` gives, or its JSON, one after the other: no more than some are held as text. Or a DataFrame
            with such JSON in a column `row`.
        effects: Files of effects that units were diagnosed with.

    Raises:
        FleetError: No rows, a unit twice, or units that were asked different things.
    """
    held = _engine.Rows()
    texts = _texts(rows)
    while some := list(itertools.islice(texts, 1000)):
        held.extend(some)
    found = held.population([os.fspath(path) for path in effects])
    return build(Fleet, {**json.loads(found.json()), "_found": found})


def _texts(rows: Rows) -> Iterator[str]:
    given = rows["row"] if hasattr(rows, "columns") else rows  # pyright: ignore[reportIndexIssue, reportCallIssue, reportArgumentType]
    for row in given:
        yield row.to_json() if isinstance(row, UnitRow) else str(row)
