"""A run in a terminal of 100 columns: the verdict and one table."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from reports.kind import kind_of
from reports.run import load

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

    from reports.page import Table as PageTable

ARROWS = {"better": "▲", "worse": "▼", "": ""}
"""Behind a number: better or worse than doing nothing, or not to be told apart."""


def summary(run_dir: Path) -> RenderableType:
    """What a run found, for ``rich.console.Console.print``; fits 100 columns.

    Parameters
    ----------
    run_dir : Path
        A folder that ``python -m bench run`` wrote.

    Raises
    ------
    ReportError
        Something in the folder is missing or damaged.
    """
    run = load(run_dir)
    return kind_of(run.sequence).summary(run)


def text_table(corner: str, headings: Iterable[str]) -> Table:
    """A table with one column of labels and one of numbers for each heading."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(corner)
    for heading in headings:
        table.add_column(heading, justify="right", overflow="fold")
    return table


def of_table(told: PageTable) -> Table:
    """A page's table without its intervals."""
    shown = text_table(told.caption, [h.replace(", ", "\n").replace(" ", "\n") for h in told.head])
    for row in told.rows:
        if row.group:
            shown.add_section()
            shown.add_row(row.group, style="bold")
        shown.add_row(row.label, *(cell.value + ARROWS[cell.mark] for cell in row.cells))
    return shown


def paragraphs(sentences: Iterable[str], style: str) -> list[RenderableType]:
    """Each sentence with an empty line below it."""
    from rich.padding import Padding
    from rich.text import Text

    return [Padding(Text(s, style=style), (0, 0, 1, 0)) for s in sentences if s]
