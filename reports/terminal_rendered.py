"""A rendered study in a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.run import Run
from reports.terminal import ARROWS, paragraphs, text_table
from reports.wording import NBSP

if TYPE_CHECKING:
    from rich.console import RenderableType

COLUMNS_PER_TABLE = 4


def summary(run: Run) -> RenderableType:
    """The verdict, and every number with its interval."""
    from rich.console import Group

    from reports.comparison import compare, left_out_text
    from reports.headline import failed_text
    from reports.tables import BASELINE_NOTE, COLUMNS, cell_text, failures, headline, mark
    from reports.verdict import mask_verdict, verdict

    comparison = compare(run)
    rows = headline(run, comparison)
    tables = []
    for start in range(0, len(rows), COLUMNS_PER_TABLE):
        shown = rows[start : start + COLUMNS_PER_TABLE]
        table = text_table("all illuminations pooled", [row.label for row in shown])
        for column in COLUMNS:
            table.add_row(
                column.heading, *(_cell(*cell_text(column, row), mark(column, row)) for row in shown)
            )
        table.add_row("SLAM runs failed", *(failed_text(row) for row in shown))
        tables.append(table)
    notes = [
        f"{BASELINE_NOTE} After a value: its 95 % interval. ▲ better, ▼ worse than doing nothing.",
        *(f"failed: {f.text}" for f in failures(run)),
    ]
    if comparison.frames.left_out:
        notes.append(left_out_text(comparison))
    sentences = [verdict(run, comparison), mask_verdict(run, comparison)]
    return Group(*paragraphs(sentences, "bold"), *tables, *paragraphs(notes, "dim"))


def _cell(value: str, bounds: str, kind: str) -> str:
    """A value, its mark and its interval on one line."""
    return f"{value}{ARROWS[kind]} {bounds.replace(NBSP, '')}".rstrip()
