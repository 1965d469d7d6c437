"""Figures of results, drawn by the engine as in its reports."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field
from typing import Any

from . import _engine


@dataclass(frozen=True)
class Figure:
    """Panels below each other. Shows itself in a notebook.

    Attributes:
        title: Headline.
        panels: Axes, series and shaded ranges of each panel as plain data, from top to bottom.
    """

    title: str
    panels: tuple[Any, ...] = field(repr=False)

    def svg(self) -> str:
        """An SVG element that shrinks with the page."""
        picture = _engine.draw(json.dumps({"title": self.title, "panels": self.panels}))
        style = f'<svg role="img" aria-label="{html.escape(self.title)}" style="max-width:100%;height:auto" '
        return picture[picture.index("<svg") :].replace("<svg ", style, 1)

    def _repr_html_(self) -> str:
        return self.svg()
