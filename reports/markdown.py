"""The tables of a page as Markdown, to be pasted where people read: a README, an issue, a paper's draft."""

from __future__ import annotations

from reports.page import Cell, Page, Table
from reports.terminal import ARROWS
from reports.wording import NBSP


def render(page: Page) -> str:
    """Title, verdict and every table with its notes."""
    parts = [f"# {page.title}", page.verdict]
    for section in page.sections:
        for table in section.tables:
            parts += [f"## {table.caption}", lines(table), *table.notes]
    return "\n\n".join(part for part in parts if part) + "\n"


def lines(table: Table) -> str:
    """One table; where its rows have groups, they are the first column."""
    grouped = any(row.group for row in table.rows)
    head = [""] * grouped + [table.corner, *table.head]
    body = [[row.group] * grouped + [row.label, *(_text(cell) for cell in row.cells)] for row in table.rows]
    return "\n".join(_line(cells) for cells in [head, ["---"] * len(head), *body])


def _text(cell: Cell) -> str:
    """Value, mark and interval: "75.6 ▼ (72.1 … 78.8)"."""
    bounds = f"({cell.interval})" if cell.interval else ""
    return " ".join(part for part in (cell.value, ARROWS[cell.mark], bounds) if part)


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '&#124;').replace(NBSP, ' ') for cell in cells)} |"
