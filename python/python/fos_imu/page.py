"""Results as a page, for those who have no notebook open."""

from __future__ import annotations

import html
from pathlib import Path as File
from typing import Protocol

from .recording import Path


class ShowsItself(Protocol):
    """A result of this package, or anything else that a notebook shows as HTML."""

    def _repr_html_(self) -> str: ...


def page(*results: ShowsItself, title: str = "fos") -> str:
    """One HTML page with these results, whole in itself: nothing is loaded, no script runs."""
    shown = "".join(result._repr_html_() for result in results)
    head = f'<meta charset="utf-8"><title>{html.escape(title)}</title>'
    return f'<!doctype html><html lang="en"><head>{head}</head><body style="max-width:900px">{shown}</body></html>\n'


def write_page(path: Path, *results: ShowsItself, title: str = "fos") -> None:
    """Writes `page(*results)`."""
    File(path).write_text(page(*results, title=title), encoding="utf-8")
