"""An image on fos-core in f32: what a device computes, over arrays, to the same bits."""

from __future__ import annotations

import enum
import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _engine, _html
from ._columns import unmasked
from ._results import build
from .errors import FosWarning, PredictorError
from .recording import Recording, engine_of

if TYPE_CHECKING:
    import pandas

Floats = npt.NDArray[np.float32]

MOST_STEPS = 10_000_000
"""Most steps of one forecast: its corrections of six axes take 840 MB."""


class Validity(enum.IntFlag):
    """Validity of a corrected value; 0 if it can be trusted."""

    WARMING_UP = 1 << 0
    """The history is not full yet: only the physical part is subtracted."""
    OWN_HISTORY = 1 << 1
    """Some of the history is the model's own prediction: normal while coasting and for a few samples after it."""
    COASTING_TOO_LONG = 1 << 2
    """For longer than the model was validated for: the stochastic part fades out."""
    OUTPUT_OUT_OF_RANGE = 1 << 3
    """The remainder is far outside what was seen while fitting."""
    INPUT_OUT_OF_RANGE = 1 << 4
    """An input is outside what was seen while fitting."""
    NOT_FINITE = 1 << 5
    """The measured value is NaN or infinite."""
    INPUT_NOT_FINITE = 1 << 6
    """A logged quantity is not there."""
    SATURATED = 1 << 7
    """The measured value is at or beyond full scale."""
    STUCK = 1 << 8
    """The measured value has repeated for longer than noise allows."""
    MISSING = 1 << 9
    """There was no sample."""
    NOT_MODELLED = 1 << 10
    """The model does not have this axis."""
    AWAY_FROM_GRAVITY = 1 << 11
    """The three accelerometers together were further from gravity than as measured; said by a hub alone."""


@dataclass(frozen=True, eq=False)
class Corrections:
    """What the model says of samples, arrays of shape `(n_rows, n_axes)` in the order of `axes`.

    Attributes:
        axes: Columns of the axes.
        predicted: Predicted error, offset included, unit of the axis: what was subtracted; float32.
        innovation: Measured error − predicted, unit of the axis; NaN where the true value is not known; float32.
        corrected: Measured − predicted, unit of the axis; float32.
        validity: Bits of `Validity`; uint16.
        still: Where the unit was taken to be still, shape `(n_rows,)`.
        time_s: Timestamps, s, shape `(n_rows,)`; None of samples that have none.
    """

    axes: tuple[str, ...]
    predicted: Floats
    innovation: Floats
    corrected: Floats
    validity: npt.NDArray[np.uint16]
    still: npt.NDArray[np.bool_]
    time_s: npt.NDArray[np.float64] | None = field(default=None)

    def to_pandas(self) -> pandas.DataFrame:
        """Corrected values by axis, the timestamps as index."""
        import pandas

        index = None if self.time_s is None else pandas.Index(self.time_s, name="t_s")
        return pandas.DataFrame(self.corrected, columns=list(self.axes), index=index)


@dataclass(frozen=True)
class _About:
    axes: tuple[str, ...]
    quantities: tuple[str, ...]
    period_s: float
    sensor: str
    effects: tuple[str, ...]
    provenance: tuple[str, ...]
    terms: int
    bytes: int
    version: int
    description: str


class Predictor:
    """The model of an image, as a device runs it.

    Args:
        image: What `Study.export_image` or `fos export --image` wrote; of earlier versions too.
        axes: Columns of the axes, where the image does not name them.

    Raises:
        ImageError: It is no image, is damaged, or of a version that is not known.
    """

    def __init__(self, image: bytes, axes: Sequence[str] = ()) -> None:
        self._engine = _engine.Predictor(bytes(image), list(axes))
        self._about = build(_About, json.loads(self._engine.about()))

    @property
    def axes(self) -> tuple[str, ...]:
        """Columns of its axes, in the order of the arrays."""
        return self._about.axes

    @property
    def quantities(self) -> tuple[str, ...]:
        """Columns of the quantities that it needs, in the order of the arrays."""
        return self._about.quantities

    @property
    def period_s(self) -> float:
        """The sample period that it was fitted to, s."""
        return self._about.period_s

    @property
    def sensor(self) -> str:
        """The sensor, as its user named it."""
        return self._about.sensor

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects that its physical part describes."""
        return self._about.effects

    @property
    def provenance(self) -> tuple[str, ...]:
        """Where the model comes from, line by line."""
        return self._about.provenance

    @property
    def description(self) -> str:
        """The model in words, with units."""
        return self._about.description

    def run(self, log: Recording) -> Corrections:
        """Runs over a log from power-on: tracks where it is still, coasts where it moves. The state of the predictor that
        `step` goes on from is not touched.

        Raises:
            RecordingError: A column that it needs is missing.
        """
        arrays, still, off = self._engine.run(engine_of(log))
        if off is not None:
            text = f"the log runs at another rate than the model: its lags are {100 * off:.1f} % off in time"
            warnings.warn(text, FosWarning, stacklevel=2)
        return Corrections(self.axes, *arrays, still, log.time_s)

    def step(
        self, measured: npt.ArrayLike, quantities: npt.ArrayLike | None = None, *, still: npt.ArrayLike = True
    ) -> Corrections:
        """Runs over samples from where the last call ended; in pieces it gives the same bits as at once.

        Args:
            measured: Shape `(n_rows, n_axes)`, or `(n_rows,)` of one axis; SI units; taken as float32.
            quantities: Shape `(n_rows, n_quantities)`, in the order of `quantities`; not needed where there is none.
            still: Where the true value is known: `True`, or shape `(n_rows,)`. Elsewhere the model coasts.

        Raises:
            PredictorError: Shapes that do not fit the model.
        """
        samples = _rows(measured, len(self.axes))
        given = np.zeros((len(samples), 0), np.float32) if quantities is None else quantities
        # where the flag is masked the true value is not known
        known = np.ma.filled(still, False) if isinstance(still, np.ma.MaskedArray) else still
        flags = np.broadcast_to(np.asarray(known, bool), (len(samples),))
        arrays = self._engine.step(samples, _rows(given, len(self.quantities)), flags.tolist())
        return Corrections(self.axes, *arrays, flags.copy())

    def forecast(self, steps: int, quantities: npt.ArrayLike | None = None) -> Corrections:
        """The samples that follow, from the model's own history.

        Args:
            steps: How many.
            quantities: Shape `(steps, n_quantities)`; not needed where the model has none.

        Raises:
            PredictorError: More steps than `MOST_STEPS`, or fewer than none; shapes that do not fit the model.
        """
        if not 0 <= steps <= MOST_STEPS:
            raise PredictorError(
                f"{steps} steps: a forecast has 0 to {MOST_STEPS}",
                remedy="forecast in pieces: each goes on from the last",
            )
        given = np.zeros((steps, 0), np.float32) if quantities is None else quantities
        arrays = self._engine.forecast(_rows(given, len(self.quantities)), steps)
        return Corrections(self.axes, *arrays, np.zeros(steps, bool))

    def skip(self, samples: int) -> None:
        """So many samples are missing.

        Raises:
            PredictorError: Fewer than none, or more than 32 bits hold.
        """
        if not 0 <= samples < 1 << 32:
            raise PredictorError(f"{samples} samples cannot be skipped", remedy="0 to 4294967295; or `reset`")
        self._engine.skip(samples)

    def reset(self) -> None:
        """As at power-on: history, inputs and clocks are reset."""
        self._engine.reset()

    def __repr__(self) -> str:
        return f"<Predictor of {', '.join(self.axes)}: {self._about.terms} terms, {self._about.bytes} bytes>"

    def _repr_html_(self) -> str:
        about = self._about
        rows: list[tuple[object, ...]] = [
            ("axes", ", ".join(about.axes)),
            ("quantities", ", ".join(about.quantities)),
            ("sample rate, Hz", f"{1 / about.period_s:.4f}"),
            ("terms", about.terms),
            ("bytes", about.bytes),
            ("effects", ", ".join(about.effects)),
        ]
        return _html.card(
            about.sensor or "model image",
            _html.table(("", ""), rows),
            *(_html.paragraph(line) for line in about.provenance),
        )


def _rows(values: npt.ArrayLike, columns: int) -> Floats:
    array = np.asarray(unmasked(values), np.float32)
    return array.reshape(-1, 1) if array.ndim == 1 and columns == 1 else np.atleast_2d(array)
