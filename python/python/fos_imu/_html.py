"""Cards and tables that results show themselves as in a notebook. All text is escaped; nothing is loaded from outside."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from .figure import Figure

STYLE = (
    "border:1px solid #d0d5dd;border-radius:6px;padding:10px 14px;margin:6px 0;"
    "font:13px/1.45 system-ui,sans-serif;color:#1b1f24;background:#fff"
)
GOOD, BAD, PLAIN = "#00734f", "#a94400", "#475467"


class Raw(str):
    """Markup that is written as it is."""

    __slots__ = ()


def escaped(value: object) -> str:
    """A cell or a paragraph."""
    return value if isinstance(value, Raw) else html.escape(str(value))


def number(value: float | None, digits: int = 4) -> str:
    """In so many significant digits; a dash where there is none."""
    return "–" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def percent(value: float | None) -> str:
    """A share."""
    return "–" if value is None or math.isnan(value) else f"{100 * value:.1f} %"


def rms_percent(share: float | None) -> str:
    """A share of a variance, as the reduction of the RMS."""
    return percent(None if share is None else 1 - max(1 - share, 0.0) ** 0.5)


def paragraph(text: object, colour: str = PLAIN) -> str:
    """A line of text."""
    return f'<p style="margin:4px 0;color:{colour}">{escaped(text)}</p>'


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table, its first column to the left, numbers to the right."""

    def cell(tag: str, value: object, first: bool) -> str:
        align = "left" if first or isinstance(value, Raw) else "right"
        style = f"text-align:{align};padding:1px 10px 1px 0;border:0;background:none;color:#1b1f24;font:inherit"
        return f'<{tag} style="{style}">{escaped(value)}</{tag}>'

    def row(tag: str, values: Sequence[object]) -> str:
        return f"<tr>{''.join(cell(tag, value, index == 0) for index, value in enumerate(values))}</tr>"

    body = "".join(row("td", values) for values in rows)
    style = "border-collapse:collapse;margin:6px 0;font-variant-numeric:tabular-nums"
    return f'<table style="{style}"><thead>{row("th", header)}</thead><tbody>{body}</tbody></table>'


def card(title: str, *parts: str, colour: str = "#1b1f24") -> str:
    """A framed block with a title."""
    head = f'<div style="font-weight:600;font-size:14px;color:{colour}">{escaped(title)}</div>'
    return f'<div style="{STYLE}">{head}{"".join(parts)}</div>'


def pictures(*figures: Figure | None) -> tuple[str, ...]:
    """The figures that there are."""
    return tuple(figure.svg() for figure in figures if figure is not None)


def sparkline(values: npt.NDArray[np.float64], width: int = 120, height: int = 20) -> Raw:
    """Range of a channel in equal parts of its rows, without axes."""
    parts = [part[np.isfinite(part)] for part in np.array_split(values, width)]
    ranges = [(i, part.min(), part.max()) for i, part in enumerate(parts) if part.size]
    least = min((low for _, low, _ in ranges), default=0.0)
    span = max((high - least for _, _, high in ranges), default=0.0) or 1.0

    def at(value: float, bottom: int) -> str:
        return f"{bottom - (value - least) / span * (height - 2):.1f}"

    bars = "".join(f'<path d="M{i} {at(high, height - 1)}V{at(low, height)}"/>' for i, low, high in ranges)
    return Raw(f'<svg width="{width}" height="{height}" stroke="#0072b2" stroke-width="1" fill="none">{bars}</svg>')
