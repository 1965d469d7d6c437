"""Logs: read from files in any known format, or made of arrays."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _engine, _html
from ._columns import columns_of
from ._results import build

if TYPE_CHECKING:
    import pandas

Path = str | os.PathLike[str]
Floats = npt.NDArray[np.float64]

AXES = ("ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads")
"""The inertial channels: specific force, m/s², and angular rate, rad/s."""


@dataclass(frozen=True)
class Source:
    """Where data came from.

    Attributes:
        path: The file as it was given; of arrays the name that they were given.
        bytes: Size of the file; 0 of arrays.
        sha256: Digest of the file, or of names and values of the arrays, hexadecimal.
    """

    path: str
    bytes: int
    sha256: str


@dataclass(frozen=True)
class Channel:
    """A measured quantity.

    Attributes:
        name: As in the log format; its last part says the unit, as in `gx_rads`, `temp_c`.
        unit: As people write it; empty where the name does not say.
        label: As people call it, as `gyro x`.
        missing: How many of its values are missing (NaN).
    """

    name: str
    unit: str
    label: str
    missing: int


@dataclass(frozen=True)
class _Summary:
    sources: tuple[Source, ...]
    n_rows: int
    duration_s: float
    rate_hz: float
    period_s: float
    jitter_s: float
    samples_missing: int
    segments: tuple[tuple[int, int], ...]
    channels: tuple[Channel, ...]
    notes: tuple[str, ...]


class Recording(Mapping[str, Floats]):
    """Measured data of one sensor: channels in SI units on a common time base, in segments without gaps.

    Made by `read`, `Recording.from_arrays`, `simulate`. A mapping of channel names to arrays of shape `(n_rows,)`, which
    are copied out of the engine when they are first asked for and must not be written to.
    """

    def __init__(self, engine: _engine.Recording) -> None:
        """Not to be called: use `read` or `from_arrays`."""
        self._engine = engine
        self._about = build(_Summary, json.loads(engine.summary()))
        self._arrays: dict[str, npt.NDArray[Any]] = {}

    @classmethod
    def from_arrays(
        cls,
        arrays: object,
        *,
        units: Mapping[str, str] | None = None,
        map: Sequence[str] = (),
        rate_hz: float | None = None,
        keep_moved: bool = False,
        name: str = "arrays",
    ) -> Recording:
        """A recording of columns in memory.

        Args:
            arrays: A dict of arrays of shape `(n_rows,)`, a DataFrame of pandas or polars, a table of pyarrow, or any
                object with `__arrow_c_stream__`. Columns are named as in the log format: `t_s`, `ax_mps2` … `gz_rads`,
                `temp_c`, `supply_v`, `load_pct`, `mag_x_ut` …, `ref_gx_rads` … (true values), `still` (0 or 1),
                `segment`; any other may be an input. Each is copied once, into the engine, as 64-bit floats.
            units: Units that columns come in where it is not the one that their name says, as `{"gx_rads": "dps"}`; one
                that is named otherwise is given in `map`.
            map: Columns under other names, converted: `"gx_rads=gyro_x:mdps"`, `"t_s=time:us"`,
                `"gx_rads=counts:*1.33e-4:rad/s"`; `"!temp_c"` leaves one out.
            rate_hz: Nominal sample rate, Hz; needed where there is no column of timestamps.
            keep_moved: Keep rows with detected motion.
            name: What studies and reports call the data.

        Raises:
            RecordingError: Columns of different length, no time and no rate, a unit that is not known.
        """
        columns = columns_of(arrays)
        entries = [*map, *(f"{column}={_quoted(column)}:{unit}" for column, unit in (units or {}).items())]
        return cls(_engine.Recording.from_columns(name, columns, entries, rate_hz, keep_moved))

    @property
    def channels(self) -> tuple[Channel, ...]:
        """All channels, in the order of the file."""
        return self._about.channels

    @property
    def axes(self) -> tuple[str, ...]:
        """The inertial channels that it has, as `gx_rads`."""
        return tuple(axis for axis in AXES if axis in self)

    @property
    def sources(self) -> tuple[Source, ...]:
        """Where it came from: one file, or those it was joined of."""
        return self._about.sources

    @property
    def n_rows(self) -> int:
        """Number of samples, of all segments together."""
        return self._about.n_rows

    @property
    def rate_hz(self) -> float:
        """The true sample rate, as measured, Hz."""
        return self._about.rate_hz

    @property
    def period_s(self) -> float:
        """The sample period, s."""
        return self._about.period_s

    @property
    def jitter_s(self) -> float:
        """How far the timestamps scatter about a regular grid, s."""
        return self._about.jitter_s

    @property
    def duration_s(self) -> float:
        """From the first sample to the last, s."""
        return self._about.duration_s

    @property
    def samples_missing(self) -> int:
        """Samples that were lost; none in a pause."""
        return self._about.samples_missing

    @property
    def segments(self) -> tuple[slice, ...]:
        """Stretches of rows without gaps, in order; together they are all rows."""
        return tuple(slice(start, stop) for start, stop in self._about.segments)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed while reading, and what was wrong with the log."""
        return self._about.notes

    @property
    def time_s(self) -> Floats:
        """Time of every row as stamped, s, shape `(n_rows,)`."""
        return self._kept("t_s", self._engine.time_s)

    @property
    def still(self) -> npt.NDArray[np.bool_] | None:
        """Where the log itself says that the unit is still, shape `(n_rows,)`; None if it does not say."""
        still = self._engine.still()
        return None if still is None else _locked(still)

    def at_rest(self) -> npt.NDArray[np.bool_]:
        """Where the unit is taken to be at rest, shape `(n_rows,)`: by the log's own column, by the detector that runs on
        the device, or, without all six axes, everywhere; less the rows with detected motion.
        """
        return _locked(self._engine.stillness()[0])

    def __getitem__(self, name: str) -> Floats:
        """The values of a channel in its unit, shape `(n_rows,)`; NaN where one is missing.

        Raises:
            KeyError: There is none of this name.
        """
        if name not in self:
            raise KeyError(name)
        return self._kept(name, lambda: self._engine.column(name))

    def __contains__(self, name: object) -> bool:
        return any(channel.name == name for channel in self.channels)

    def __iter__(self) -> Iterator[str]:
        return (channel.name for channel in self.channels)

    def __len__(self) -> int:
        return len(self.channels)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Recording) and self._about == other._about

    __hash__ = None  # type: ignore[assignment]

    def write(self, path: Path) -> None:
        """Writes it in the log format: `.parquet` (every bit), `.csv` or `.csv.gz`, atomically.

        Raises:
            FileError: The file cannot be written.
            RecordingError: The name does not say the format.
        """
        self._engine.write(os.fspath(path))

    def to_pandas(self) -> pandas.DataFrame:
        """As a DataFrame, the timestamps as its index."""
        import pandas

        return pandas.DataFrame(dict(self), index=pandas.Index(self.time_s, name="t_s"))

    def _kept(self, name: str, column: Any) -> Any:  # noqa: ANN401
        if name not in self._arrays:
            self._arrays[name] = _locked(column())
        return self._arrays[name]

    def __repr__(self) -> str:
        names = ", ".join(source.path for source in self.sources)
        return f"<Recording {names}: {self.n_rows} rows, {self.duration_s:.1f} s at {self.rate_hz:.3f} Hz, {', '.join(self)}>"

    def _repr_html_(self) -> str:
        rows: list[tuple[object, ...]] = []
        for channel in self.channels:
            values = self[channel.name]
            finite = values[np.isfinite(values)]
            low, mean, high = (finite.min(), finite.mean(), finite.max()) if finite.size else (np.nan, np.nan, np.nan)
            numbers = tuple(_html.number(value) for value in (low, mean, high))
            rows.append((channel.name, channel.unit, *numbers, channel.missing or "", _html.sparkline(values)))
        facts = f"{self.n_rows} rows, {self.duration_s:.1f} s at {self.rate_hz:.3f} Hz, {len(self.segments)} segments"
        return _html.card(
            ", ".join(source.path for source in self.sources),
            _html.paragraph(f"{facts}, {self.samples_missing} samples missing"),
            _html.table(("channel", "unit", "least", "mean", "largest", "missing", ""), rows),
            *(_html.paragraph(note) for note in self.notes),
        )


@overload
def engine_of(log: Recording) -> _engine.Recording: ...
@overload
def engine_of(log: Recording | None) -> _engine.Recording | None: ...
def engine_of(log: Recording | None) -> _engine.Recording | None:
    """The log as the engine has it."""
    return None if log is None else log._engine


def _quoted(column: str) -> str:
    return f'"{column}"' if ":" in column else column


def _locked(array: Any) -> Any:  # noqa: ANN401
    array.flags.writeable = False
    return array


def read(
    path: Path,
    *,
    map: Sequence[str] = (),
    rate_hz: float | None = None,
    format: str | None = None,
    topic: str | None = None,
    strict: bool = False,
    keep_moved: bool = False,
) -> Recording:
    """Reads a log; its format is recognised by its content.

    Args:
        path: PX4 ULog, ArduPilot DataFlash, MCAP and ROS 1 bags, EuRoC, Kalibr, phone apps, ST tools, Betaflight, or any
            CSV, gzip'd CSV or Parquet; `formats()` lists them.
        map: Columns under other names, converted: `"gx_rads=gyro_x:mdps"`, `"t_s=time:us"`; `"!temp_c"` leaves one out.
        rate_hz: Sample rate, Hz; needed where the log has no timestamps, and replaces timestamps that show another rate.
        format: The format by its identifier, where the content does not tell.
        topic: Which sensor, where a log has several.
        strict: Refuse the first row that cannot be used, instead of counting up to 5 % of them.
        keep_moved: Keep rows with detected motion.

    Raises:
        FileError: It cannot be opened or read.
        RecordingError: It is no log, or not one that can be used; with line and column where there are.
    """
    return Recording(_engine.load(os.fspath(path), list(map), rate_hz, format, topic, strict, keep_moved))


def formats() -> dict[str, str]:
    """The formats of other programs that are read: identifier, and what it is."""
    return dict(_engine.formats())
