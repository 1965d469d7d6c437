"""Missing effects: a verdict with its evidence."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from . import _engine, _html
from ._results import build
from .figure import Figure
from .recording import Path, Recording, engine_of

if TYPE_CHECKING:
    import pandas

Band = Literal["slow", "wide", "data", "stochastic"]
"""Where an effect shows: in block means, in single samples, in the data before any physics, as noise."""

Interval = tuple[float, float]


@dataclass(frozen=True)
class Size:
    """How large an effect is, in the units of data sheets.

    Attributes:
        of: The regressor, as `temp_c:lowpass(61)`.
        value: In `unit`.
        interval: 95 %, in `unit`; an end that is not known is NaN.
        unit: As data sheets state it, as `dps/K`.
    """

    of: str
    value: float
    interval: Interval
    unit: str


@dataclass(frozen=True)
class Separation:
    """The experiment that tells a finding from a rival."""

    effect: str
    experiment: str


@dataclass(frozen=True)
class CorrectionTerm:
    """One term of the correction by a finding: coefficient times regressor, in the unit of the axis (SI).

    Attributes:
        regressor: A product of inputs.
        coefficient: Unit of the axis per unit of the product.
        standard_error: In the same.
    """

    regressor: str
    coefficient: float
    standard_error: float


@dataclass(frozen=True)
class Evidence:
    """What speaks for a slow effect: means over blocks of the log where it was found.

    Attributes:
        block_s: Length of the blocks, s.
        time_s: Their middles, s as stamped, one a block.
        error: Mean error without the model and all other findings, less its mean, unit of the axis, one a block.
        effect: What the finding says of it, less its mean, unit of the axis, one a block.
        against: The column against which it shows best; None if there is none.
        against_unit: Unit of that column.
        against_values: Its mean, one a block.
    """

    block_s: float
    time_s: tuple[float, ...]
    error: tuple[float, ...]
    effect: tuple[float, ...]
    against: str | None = None
    against_unit: str | None = None
    against_values: tuple[float, ...] | None = None


@dataclass(frozen=True)
class LineEvidence:
    """What speaks for a line: the spectrum about it.

    Attributes:
        line_hz: Where the line is, Hz.
        frequency_hz: Bins, Hz.
        density: Power spectral density, one-sided, unit²/Hz, one a bin.
    """

    line_hz: float
    frequency_hz: tuple[float, ...]
    density: tuple[float, ...]


@dataclass(frozen=True)
class Cost:
    """What terms and inputs cost on the device.

    Attributes:
        terms: Physical and stochastic together.
        factors: Of all terms.
        inputs: Inputs.
        ram_bytes: RAM, bytes.
        instructions: Instructions a sample on a Cortex-M4F, about.
    """

    terms: int
    factors: int
    inputs: int
    ram_bytes: int
    instructions: int


@dataclass(frozen=True)
class Finding:
    """An effect that is missing.

    Attributes:
        effect: Its identifier, as `thermal_lag`: what `Study.add` takes.
        name: Its name, as in a sentence.
        band: Where it shows.
        params: Its parameters; their names say the units, as `tau_s`.
        params_interval: 95 % intervals of them, where they are known.
        sizes: Its size, one a regressor.
        gain: By how much −2 ln L falls with it; None for a fault of the data.
        score: The gain after the price of its coefficients and of everything that was tried; accepted from 9 (lines: 15).
            None for a fault of the data.
        predicted_reduction: Share of the error of its band that should go, 0 … 1: of the variance of 1-s means (slow),
            of the samples (wide).
        predicted_reduction_interval: 90 %.
        measured_reduction: The share that went on the evaluation log; None where none was given.
        doubt: Why it is not conclusive; None if it is.
        confounded_with: Effects that are indistinguishable from it in this log.
        separate: The experiments that would.
        shows_against: The column against which it shows best.
        shows_from_to_s: Where it is largest, s as stamped.
        correction: The correction that it adds.
        evidence: What speaks for it, if it is slow.
        line: What speaks for it, if it is a line.
        figure: The same drawn.
        cost: What the model would cost more with it; None without a model.
    """

    effect: str
    name: str
    band: Band
    params: Mapping[str, float]
    params_interval: Mapping[str, Interval]
    sizes: tuple[Size, ...]
    gain: float | None
    score: float | None
    predicted_reduction: float
    predicted_reduction_interval: Interval
    confounded_with: tuple[str, ...]
    separate: tuple[Separation, ...]
    shows_against: str | None
    shows_from_to_s: Interval | None
    correction: tuple[CorrectionTerm, ...]
    measured_reduction: float | None = None
    doubt: str | None = None
    evidence: Evidence | None = None
    line: LineEvidence | None = None
    figure: Figure | None = field(default=None, repr=False)
    cost: Cost | None = None

    def _repr_html_(self) -> str:
        return _finding(self)


@dataclass(frozen=True)
class Lead:
    """What the rest of the error follows; no finding.

    Attributes:
        follows: In words.
        score: As of a finding.
        share: Its share of the variance of the block means of the residual.
    """

    follows: str
    score: float
    share: float


@dataclass(frozen=True)
class Rejected:
    """An effect that was tried and not chosen: its score alone, and why if that would have done."""

    effect: str
    score: float
    why: str | None = None


@dataclass(frozen=True)
class Untested:
    """An effect that could not be tried, and what of its columns the log does not have."""

    effect: str
    needs: tuple[str, ...]


@dataclass(frozen=True)
class NoiseLevels:
    """Noise of an axis, in its unit.

    Attributes:
        white: N, unit·√s.
        flicker: B, unit.
        walk: K, unit/√s.
    """

    white: float
    flicker: float
    walk: float


@dataclass(frozen=True)
class NoiseReport:
    """The noise that the evidence rests on.

    Attributes:
        levels: With everything that was found.
        learnt_from: Where they were learnt from, in words.
        block_s: Length of the blocks that slow effects were looked for in, s.
        blocks: How many there are.
    """

    levels: NoiseLevels
    learnt_from: str
    block_s: float
    blocks: int


@dataclass(frozen=True)
class Diagnosis:
    """Missing effects on a log, with a model or without. Shows itself in a notebook with the evidence.

    Attributes:
        target: The column that was explained.
        unit: Its unit.
        verdict: `missing`: effects of the library are; `nothing_missing`; `unexplained`: something is, and nothing in the
            library explains it; `not_enough_data`: no slow effect could be tested.
        sentence: The outcome in a sentence.
        findings: Missing effects, best first, then faults of the data.
        leads: What else the log follows; no findings.
        rejected: Effects that were tried and not chosen, the nearest first.
        tested: Slow effects that were tested.
        untested: Effects that could not be tested.
        noise: The noise that the evidence rests on.
        cautions: Why the answer should be taken with care.
        moved: Detected motion in a log at rest.
        notes: Properties of the log that are no faults, as its duty cycle.
    """

    target: str
    unit: str
    verdict: Literal["missing", "nothing_missing", "unexplained", "not_enough_data"]
    sentence: str
    findings: tuple[Finding, ...]
    leads: tuple[Lead, ...]
    rejected: tuple[Rejected, ...]
    untested: tuple[Untested, ...]
    noise: NoiseReport
    cautions: tuple[str, ...]
    moved: tuple[str, ...] = field(default=())
    tested: tuple[str, ...] = field(default=())
    notes: tuple[str, ...] = field(default=())

    def to_pandas(self) -> pandas.DataFrame:
        """One row a finding: effect, score, size and its interval, predicted and measured reduction."""
        import pandas

        def row(finding: Finding) -> dict[str, Any]:
            size = finding.sizes[0] if finding.sizes else None
            return {
                "effect": finding.effect,
                "band": finding.band,
                "score": float("nan") if finding.score is None else finding.score,
                **finding.params,
                "size": size.value if size else float("nan"),
                "size_low": size.interval[0] if size else float("nan"),
                "size_high": size.interval[1] if size else float("nan"),
                "size_unit": size.unit if size else "",
                "predicted_reduction": finding.predicted_reduction,
                "predicted_low": finding.predicted_reduction_interval[0],
                "predicted_high": finding.predicted_reduction_interval[1],
                "measured_reduction": finding.measured_reduction,
            }

        return pandas.DataFrame([row(finding) for finding in self.findings])

    def __str__(self) -> str:
        return f"{self.target}: {self.sentence}"

    def _repr_html_(self) -> str:
        colours = {"nothing_missing": _html.GOOD, "not_enough_data": _html.PLAIN}
        notes = [f"caution: {caution}" for caution in self.cautions] + [f"motion: {moved}" for moved in self.moved]
        notes += [f"note: {note}" for note in self.notes]
        leads = "; ".join(lead.follows for lead in self.leads[:3])
        near = ", ".join(f"{one.effect} ({one.score:.0f})" for one in self.rejected[:6])
        noise = (
            f"noise estimated from {self.noise.learnt_from}; {self.noise.blocks} blocks of {self.noise.block_s:.2f} s"
        )
        tail = [
            text
            for text, shown in (
                (f"leads in the residual (not findings): {leads}", leads),
                (f"tested alone and not chosen, with score: {near}", near),
                (noise, noise),
            )
            if shown
        ]
        return _html.card(
            f"{self.target}: {self.sentence}",
            *(_html.paragraph(note, _html.BAD) for note in notes),
            *(_finding(finding) for finding in self.findings),
            *(_html.paragraph(text) for text in tail),
            colour=colours.get(self.verdict, _html.BAD),
        )


def _finding(finding: Finding) -> str:
    number, percent = _html.number, _html.rms_percent
    low, high = finding.predicted_reduction_interval
    rows: list[tuple[object, ...]] = [
        (
            _size_of(finding, size),
            f"{number(size.value)} ({number(size.interval[0])} … {number(size.interval[1])}) {size.unit}",
        )
        for size in finding.sizes
    ]
    rows += [(name, _with_interval(value, finding.params_interval.get(name))) for name, value in finding.params.items()]
    rows.append(
        ("predicted reduction of the RMS", f"{percent(finding.predicted_reduction)} ({percent(low)} … {percent(high)})")
    )
    if finding.measured_reduction is not None:
        rows.append(("measured reduction of the RMS", percent(finding.measured_reduction)))
    if finding.cost is not None:
        cost = finding.cost
        more = f"{cost.terms} terms, {cost.ram_bytes} bytes of RAM, {cost.instructions} instructions a sample"
        rows.append(("costs more on the device", more))
    if finding.score is not None:
        rows.append(("score", f"{finding.score:.0f}"))
    doubt = [_html.paragraph(f"not conclusive: {finding.doubt}", _html.BAD)] if finding.doubt else []
    rivals = [f"indistinguishable from {other.effect}: {other.experiment}" for other in finding.separate]
    return _html.card(
        f"{finding.name} ({finding.effect})",
        *doubt,
        _html.table(("", ""), rows),
        *(_html.paragraph(rival) for rival in rivals),
        *_html.pictures(finding.figure),
    )


def _size_of(finding: Finding, size: Size) -> str:
    # a fitted time constant has as many digits as a number can have
    regressor = re.sub(r"\d+\.\d{3,}", lambda digits: _html.number(float(digits[0]), 3), size.of)
    return f"size of {regressor}" if len(finding.sizes) > 1 else "size"


def _with_interval(value: float, interval: Interval | None) -> str:
    text = _html.number(value)
    return text if interval is None else f"{text} ({_html.number(interval[0])} … {_html.number(interval[1])})"


def diagnosis_of(answer: str, speaks: str) -> Diagnosis:
    """A diagnosis as the engine hands it over, with what speaks for each finding."""
    data: dict[str, Any] = json.loads(answer)
    found = zip(data.pop("findings"), json.loads(speaks), strict=True)
    diagnosis = build(Diagnosis, {**data, "findings": ()})
    return replace(diagnosis, findings=tuple(finding_of({**finding, **beside}) for finding, beside in found))


def finding_of(data: Mapping[str, Any]) -> Finding:
    """A finding as answers and studies have it."""
    names = {
        "expected_drop": "predicted_reduction",
        "expected_drop_ci": "predicted_reduction_interval",
        "realised_fall": "measured_reduction",
    }
    return build(Finding, {names.get(key, key): value for key, value in data.items()})


def diagnose(
    log: Recording,
    *,
    axis: str,
    reference: Recording | None = None,
    evaluate_on: Recording | None = None,
    full_scale: float | None = None,
    lsb: float | None = None,
    effects: Sequence[Path] = (),
) -> Diagnosis:
    """Identifies the missing effects of an axis of a log, without a model. With one: `Study.diagnose`.

    Args:
        log: The log to explain: at least 60 blocks at rest, better half an hour.
        axis: As `gx`, or a column.
        reference: A log of the same device under steady conditions; it fixes the noise.
        evaluate_on: A later log; the reduction is measured on it.
        full_scale: Full scale of the axis, in its unit.
        lsb: Least significant bit of the axis, in its unit.
        effects: Effects of your own, one TOML file each.

    Raises:
        RecordingError: A column is missing.
        DiagnoseError: The log is too short, or the axis is stuck.
    """
    answer = _engine.diagnose(
        engine_of(log),
        axis,
        engine_of(reference),
        engine_of(evaluate_on),
        full_scale,
        lsb,
        [os.fspath(path) for path in effects],
    )
    return diagnosis_of(*answer)


@dataclass(frozen=True)
class Effect:
    """A physical effect of the library.

    Attributes:
        id: Its identifier, the same everywhere.
        name: As in a sentence.
        band: Where it shows.
        mechanism: What happens in the sensor.
        equation: The error that it makes.
        experiment: Which experiment shows it.
        typical_size: How large it is on parts of phones.
        source: Where that comes from.
        gives_away: What in a plot gives it away.
        device: What it costs on the device.
    """

    id: str
    name: str
    band: Band
    mechanism: str
    equation: str
    experiment: str
    typical_size: str
    source: str
    gives_away: str
    device: str

    def _repr_html_(self) -> str:
        told = ("mechanism", "equation", "typical_size", "source", "gives_away", "experiment", "device")
        rows = [(name.replace("_", " "), _html.Raw(_html.escaped(getattr(self, name)))) for name in told]
        return _html.card(f"{self.name} ({self.id})", _html.table(("", ""), rows))


def effects(files: Sequence[Path] = ()) -> Mapping[str, Effect]:
    """The library by identifier: the built-in effects and those of these TOML files."""
    found = json.loads(_engine.effects([os.fspath(path) for path in files]))
    return MappingProxyType({one["id"]: build(Effect, one) for one in found})
