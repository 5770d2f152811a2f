"""What stands on a page, whatever kind of run it tells of; the template turns it into HTML."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from reports.strips import Strip


@dataclass(frozen=True)
class Cell:
    """One number: value, interval below it, and its mark, "better" or "worse" than doing nothing."""

    value: str = ""
    interval: str = ""
    mark: str = ""


@dataclass(frozen=True)
class TableRow:
    """A row with its heading; ``group`` starts a new group, ``quiet`` sets a reference row back."""

    label: str
    cells: tuple[Cell, ...]
    note: str = ""
    group: str = ""
    quiet: bool = False


@dataclass(frozen=True)
class Table:
    """A table; ``folded`` ones are opened by the reader.

    Attributes
    ----------
    caption, corner : str
        ``corner`` heads the column of labels.
    head : tuple of str
    rows : tuple of TableRow
    notes : tuple of str
        Below the table.
    csv : str
        Relative address of its data, or empty.
    """

    caption: str
    corner: str
    head: tuple[str, ...]
    rows: tuple[TableRow, ...]
    notes: tuple[str, ...] = ()
    csv: str = ""
    folded: bool = False


@dataclass(frozen=True)
class Picture:
    """A figure of the run folder.

    Attributes
    ----------
    path : Path
        The SVG file; its CSV has the same stem.
    title, caption : str
    """

    path: Path
    title: str
    caption: str

    @property
    def csv(self) -> str:
        """Address of its data, relative to the page."""
        return f"figures/{self.path.with_suffix('.csv').name}"

    @property
    def file(self) -> str:
        """Address of the picture itself, relative to the page."""
        return f"figures/{self.path.name}"


@dataclass(frozen=True)
class Section:
    """A heading with what belongs to it, in this order."""

    anchor: str
    heading: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    strips: tuple[Strip, ...] = ()
    strips_note: str = ""
    bullets: tuple[str, ...] = ()


@dataclass(frozen=True)
class Page:
    """The whole page.

    Attributes
    ----------
    title, subtitle, description : str
    verdict : str
        The answer, in one sentence.
    further : tuple of str
        Sentences that belong to it.
    sections : tuple of Section
    provenance : tuple of (key, value)
    """

    title: str
    subtitle: str
    description: str
    verdict: str
    further: tuple[str, ...]
    sections: tuple[Section, ...]
    provenance: tuple[tuple[str, str], ...] = field(default=())
