"""Small pictures as inline SVG: axes with ticks, lines, dots, envelopes, shaded ranges. No plotter is needed."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

MEASURED, PREDICTED, LEFT, MARKED, DARK = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#222222"
"""Colours that colour-blind people can distinguish (Okabe and Ito 2008), the same as in the program's figures."""

WIDTH, HEIGHT = 760, 240
LEFT_EDGE, RIGHT_EDGE, TOP, BOTTOM = 78, 12, 26, 42
BUCKETS = 600


@dataclass(frozen=True)
class Series:
    """What is drawn, in the order in which it is given."""

    label: str
    x: npt.ArrayLike
    y: npt.ArrayLike
    colour: str
    shape: Literal["line", "dots", "envelope", "band"] = "line"
    high: npt.ArrayLike = ()
    """Upper edge of a band, whose lower edge is y."""


def plot(
    title: str,
    x_label: str,
    y_label: str,
    series: Sequence[Series],
    *,
    logarithmic: tuple[bool, bool] = (False, False),
    shaded: Sequence[tuple[float, float]] = (),
) -> str:
    """One panel."""
    arrays = [(one, np.asarray(one.x, float), np.asarray(one.y, float), np.asarray(one.high, float)) for one in series]
    x_axis = _Axis.of([x for _, x, _, _ in arrays], logarithmic[0], LEFT_EDGE, WIDTH - RIGHT_EDGE)
    y_axis = _Axis.of([v for _, _, y, high in arrays for v in (y, high)], logarithmic[1], HEIGHT - BOTTOM, TOP)
    parts = [_frame(title, x_label, y_label, x_axis, y_axis)]
    for begin, end in shaded:
        left, right = x_axis.at(np.array([begin, end]))
        parts.append(
            f'<rect x="{left:.1f}" y="{TOP}" width="{max(right - left, 1):.1f}" height="{HEIGHT - TOP - BOTTOM}" '
            f'fill="{MARKED}" fill-opacity="0.18"/>'
        )
    for one, x, y, high in arrays:
        parts.append(_SHAPES[one.shape](one.colour, x, y, high, x_axis, y_axis))
    parts.append(_legend([(one.label, one.colour) for one in series if one.label]))
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="100%" style="max-width:{WIDTH}px;background:#fff" role="img" '
        f'aria-label="{html.escape(title)}" font-family="system-ui,sans-serif" font-size="11">{"".join(parts)}</svg>'
    )


def sparkline(values: Floats, width: int = 120, height: int = 20) -> str:
    """The course of a channel, without axes."""
    low, high = _envelope(np.arange(values.size, dtype=float), values, width)[1:]
    least, most = (np.nanmin(low), np.nanmax(high)) if np.isfinite(low).any() else (0.0, 1.0)
    span = (most - least) or 1.0
    bars = "".join(
        f'<path d="M{i} {height - 1 - (b - least) / span * (height - 2):.1f}V{height - (a - least) / span * (height - 2):.1f}"/>'
        for i, (a, b) in enumerate(zip(low, high, strict=True))
        if math.isfinite(a)
    )
    return f'<svg width="{width}" height="{height}" stroke="{MEASURED}" stroke-width="1" fill="none">{bars}</svg>'


def means(x: Floats, y: Floats, parts: int = 150) -> tuple[Floats, Floats]:
    """Means of y in equal parts of x, and their middles; NaN in a part without a value."""
    there = np.isfinite(x) & np.isfinite(y)
    sums, edges = np.histogram(x[there], parts, weights=y[there])
    counts = np.histogram(x[there], edges)[0]
    return (edges[1:] + edges[:-1]) / 2, np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


@dataclass(frozen=True)
class _Axis:
    low: float
    high: float
    begin: float
    end: float
    logarithmic: bool

    @classmethod
    def of(cls, values: Sequence[Floats], logarithmic: bool, begin: float, end: float) -> _Axis:
        parts = [v[np.isfinite(v) & ((v > 0) | (not logarithmic))] for v in values]
        everything = np.concatenate([part for part in parts if part.size] or [np.array([0.1, 1.0])])
        if logarithmic:
            everything = np.log10(everything)
        low, high = float(everything.min()), float(everything.max())
        margin = 0.04 * (high - low) or max(abs(low) * 1e-3, 1e-12)
        vertical = begin > end
        return cls(low - vertical * margin, high + vertical * margin or 1.0, begin, end, logarithmic)

    def at(self, values: Floats) -> Floats:
        scaled = np.log10(np.where(values > 0, values, np.nan)) if self.logarithmic else values
        span = (self.high - self.low) or 1.0
        return self.begin + (scaled - self.low) / span * (self.end - self.begin)

    def ticks(self) -> list[tuple[float, str]]:
        if self.logarithmic:
            powers = range(math.ceil(self.low), math.floor(self.high) + 1)
            if len(powers) > 1:
                return [(10.0**power, f"1e{power}") for power in powers]
            inside = [m * 10.0**p for p in range(math.floor(self.low), math.ceil(self.high) + 1) for m in (1, 2, 5)]
            return [(v, f"{v:.3g}") for v in inside if self.low <= math.log10(v) <= self.high]
        span = self.high - self.low
        raw = 10.0 ** math.floor(math.log10(span / 4)) if span > 0 else 1.0
        step = next(raw * m for m in (1, 2, 5, 10) if span / (raw * m) <= 6)
        first = math.ceil(self.low / step) * step
        values = [first + i * step for i in range(int((self.high - first) / step + 1e-9) + 1)]
        return [(v, f"{0.0 if abs(v) < step * 1e-6 else v:.5g}") for v in values]


def _frame(title: str, x_label: str, y_label: str, x_axis: _Axis, y_axis: _Axis) -> str:
    right, bottom = WIDTH - RIGHT_EDGE, HEIGHT - BOTTOM
    middle = (TOP + bottom) / 2
    parts = [
        f'<text x="{LEFT_EDGE}" y="14" font-weight="600" font-size="12" fill="#1b1f24">{html.escape(title)}</text>',
        f'<text x="{(LEFT_EDGE + right) / 2}" y="{HEIGHT - 8}" text-anchor="middle" fill="#475467">{html.escape(x_label)}</text>',
        f'<text transform="translate(13 {middle}) rotate(-90)" text-anchor="middle" fill="#475467">{html.escape(y_label)}</text>',
    ]
    for value, text in x_axis.ticks():
        x = float(x_axis.at(np.array(value)))
        parts.append(f'<path d="M{x:.1f} {TOP}V{bottom}" stroke="#eaecf0"/>')
        parts.append(f'<text x="{x:.1f}" y="{bottom + 14}" text-anchor="middle" fill="#475467">{text}</text>')
    for value, text in y_axis.ticks():
        y = float(y_axis.at(np.array(value)))
        parts.append(f'<path d="M{LEFT_EDGE} {y:.1f}H{right}" stroke="#eaecf0"/>')
        parts.append(f'<text x="{LEFT_EDGE - 6}" y="{y + 4:.1f}" text-anchor="end" fill="#475467">{text}</text>')
    parts.append(f'<path d="M{LEFT_EDGE} {TOP}V{bottom}H{right}" stroke="#98a2b3" fill="none"/>')
    return "".join(parts)


def _legend(entries: Sequence[tuple[str, str]]) -> str:
    parts: list[str] = []
    right = WIDTH - RIGHT_EDGE
    for label, colour in reversed(entries):
        right -= 6.2 * len(label) + 24
        parts.append(f'<rect x="{right:.0f}" y="7" width="12" height="8" fill="{colour}"/>')
        parts.append(f'<text x="{right + 16:.0f}" y="15" fill="#1b1f24">{html.escape(label)}</text>')
    return "".join(parts)


def _points(x: Floats, y: Floats, x_axis: _Axis, y_axis: _Axis) -> list[tuple[float, float]]:
    return [(float(a), float(b)) for a, b in zip(x_axis.at(x), y_axis.at(y), strict=True)]


def _line(colour: str, x: Floats, y: Floats, _high: Floats, x_axis: _Axis, y_axis: _Axis) -> str:
    path, pen_up = [], True
    for a, b in _points(x, y, x_axis, y_axis):
        if math.isfinite(a) and math.isfinite(b):
            path.append(f"{'M' if pen_up else 'L'}{a:.1f} {b:.1f}")
        pen_up = not (math.isfinite(a) and math.isfinite(b))
    return f'<path d="{"".join(path)}" stroke="{colour}" stroke-width="1.4" fill="none"/>'


def _dots(colour: str, x: Floats, y: Floats, _high: Floats, x_axis: _Axis, y_axis: _Axis) -> str:
    points = _points(x, y, x_axis, y_axis)
    dots = "".join(f"M{a:.1f} {b:.1f}h.01" for a, b in points if math.isfinite(a) and math.isfinite(b))
    return f'<path d="{dots}" stroke="{colour}" stroke-width="3" stroke-linecap="round" stroke-opacity="0.6"/>'


def _band(colour: str, x: Floats, y: Floats, high: Floats, x_axis: _Axis, y_axis: _Axis) -> str:
    there = np.isfinite(x) & np.isfinite(y) & np.isfinite(high)
    lower = _points(x[there], y[there], x_axis, y_axis)
    upper = _points(x[there], high[there], x_axis, y_axis)
    path = "L".join(f"{a:.1f} {b:.1f}" for a, b in lower + upper[::-1])
    return f'<path d="M{path}Z" fill="{colour}" fill-opacity="0.2"/>' if path else ""


def _envelope_shape(colour: str, x: Floats, y: Floats, _high: Floats, x_axis: _Axis, y_axis: _Axis) -> str:
    middle, low, high = _envelope(x, y, BUCKETS)
    a, b, c = x_axis.at(middle), y_axis.at(low), y_axis.at(high)
    bars = (f"M{i:.1f} {j + 0.5:.1f}V{k - 0.5:.1f}" for i, j, k in zip(a, b, c, strict=True) if math.isfinite(j))
    return f'<path d="{"".join(bars)}" stroke="{colour}" stroke-width="1.2" stroke-opacity="0.5"/>'


def _envelope(x: Floats, y: Floats, buckets: int) -> tuple[Floats, Floats, Floats]:
    """Least and largest y in equal parts of x; NaN in a part without a value."""
    there = np.isfinite(x) & np.isfinite(y)
    x, y = x[there], y[there]
    low, high = np.full(buckets, np.inf), np.full(buckets, -np.inf)
    if x.size:
        begin, span = x.min(), (x.max() - x.min()) or 1.0
        part = np.minimum(((x - begin) / span * buckets).astype(np.intp), buckets - 1)
        np.minimum.at(low, part, y)
        np.maximum.at(high, part, y)
        middle = begin + (np.arange(buckets) + 0.5) * span / buckets
    else:
        middle = np.zeros(buckets)
    empty = low > high
    low[empty], high[empty] = np.nan, np.nan
    return middle, low, high


_Shape = Callable[[str, Floats, Floats, Floats, _Axis, _Axis], str]
_SHAPES: dict[str, _Shape] = {"line": _line, "dots": _dots, "envelope": _envelope_shape, "band": _band}
