"""Pictures put into the page itself: SVG as markup that follows the page's theme, PNG as base64."""

from __future__ import annotations

import base64
import re
from collections import Counter
from pathlib import Path

from reports import style
from reports.errors import ReportError

THEME = {
    style.INK: "var(--ink)",
    style.MUTED: "var(--muted)",
    style.RULE: "var(--rule)",
    style.PAPER: "var(--paper)",
    style.BASELINE_COLOUR: "var(--baseline)",
    **{colour: f"var(--series-{i})" for i, colour in enumerate(style.SERIES)},
}
"""Figure colours that change with the theme; heat map cells and the text on them keep theirs."""


def png(path: Path) -> str:
    """A ``data:`` address with the picture in it."""
    return f"data:image/png;base64,{base64.b64encode(_bytes(path)).decode('ascii')}"


def svg(path: Path) -> str:
    """An SVG file as markup for an HTML page: no prologue, ids of its own, theme colours.

    Raises
    ------
    ReportError
        The file is missing or no SVG.
    """
    text = _bytes(path).decode("utf-8", errors="replace")
    start = text.find("<svg")
    if start < 0:
        raise ReportError(f"{path} is no SVG picture: build the report again")
    text = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", text[start:], flags=re.DOTALL)
    text = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", text)
    text = _own_ids(text, path.stem)
    for colour, variable in THEME.items():
        text = text.replace(colour, variable)
    text = re.sub(r"font-family: 'DejaVu Sans', sans-serif", "font-family: var(--sans)", text)
    # the page, not the file, decides how wide a figure is
    text = re.sub(r'(<svg[^>]*?)\swidth="[^"]*"', r"\1", text, count=1)
    return re.sub(r'(<svg[^>]*?)\sheight="[^"]*"', r"\1", text, count=1).strip()


def _own_ids(text: str, prefix: str) -> str:
    """Prefix every id, so that two figures on one page cannot refer to each other's parts.

    A picture drawn twice in a figure has the same id twice, and nothing refers to it: repeats are numbered.
    """
    seen: Counter[str] = Counter()

    def own(match: re.Match[str]) -> str:
        seen[match[1]] += 1
        repeat = f"-{seen[match[1]]}" if seen[match[1]] > 1 else ""
        return f'id="{prefix}-{match[1]}{repeat}"'

    text = re.sub(r'\bid="([^"]*)"', own, text)
    text = re.sub(r"url\(#", f"url(#{prefix}-", text)
    return re.sub(r'href="#', f'href="#{prefix}-', text)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ReportError(f"{path} is missing: build the report again") from error
