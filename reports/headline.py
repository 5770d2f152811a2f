"""The headline table as it stands on the page and in ``figures/headline.csv``."""

from __future__ import annotations

from dataclasses import astuple

from reports.comparison import Comparison, Condition
from reports.figures_effects import POOLED
from reports.illuminations import illuminations
from reports.page import Cell, Table, TableRow
from reports.run import Run
from reports.style import write_csv
from reports.tables import BASELINE_NOTE, COLUMNS, Column, Row, cell_text, headline, mark

CSV = "figures/headline.csv"
MARK_NOTE = (
    "Below a value: its 95 % interval. ▲ better, ▼ worse than doing nothing: the interval of the paired "
    "difference excludes zero."
)
Block = tuple[str, tuple[Row, ...]]


def tables(run: Run, comparison: Comparison) -> tuple[Table, ...]:
    """All illuminations pooled, one number a line; then each illumination, one filter a line."""
    conditions: list[tuple[str, Condition]] = [(POOLED, None)]
    conditions += [(light.label, light.name) for light in illuminations(run)]
    blocks = [(label, headline(run, comparison, condition)) for label, condition in conditions]
    _save(run, blocks)
    return (_pooled(blocks[0][1]), _by_illumination(blocks[1:]))


def _pooled(rows: tuple[Row, ...]) -> Table:
    lines = [
        TableRow(column.heading, tuple(_cell(column, row) for row in rows), group=column.group)
        for column in COLUMNS
    ]
    lines.append(TableRow("SLAM runs that failed", tuple(Cell(failed_text(row)) for row in rows)))
    notes = [BASELINE_NOTE, MARK_NOTE]
    if any(row.failed for row in rows):
        notes.append(
            "A failed run has no RMSE, map or path: these numbers are over the runs that went through."
        )
    missing = sorted({v.note for row in rows for v in row.cells.values() if v.note.startswith("too few")})
    notes += [f"No interval where there are {note}." for note in missing]
    head = tuple(row.label for row in rows)
    return Table("All illuminations pooled", "", head, tuple(lines), tuple(notes), CSV)


def _by_illumination(blocks: list[Block]) -> Table:
    lines = [
        TableRow(
            row.label,
            (*(_cell(c, row) for c in COLUMNS), Cell(failed_text(row))),
            group=label * (i == 0),
        )
        for label, rows in blocks
        for i, row in enumerate(rows)
    ]
    head = (*(column.heading for column in COLUMNS), "failed")
    return Table("Each illumination", "filter", head, tuple(lines), (BASELINE_NOTE,), CSV, folded=True)


def _cell(column: Column, row: Row) -> Cell:
    return Cell(*cell_text(column, row), mark(column, row))


def failed_text(row: Row) -> str:
    """How many of a row's SLAM runs failed."""
    return f"{row.failed} of {row.runs}" if row.runs else ""


def _save(run: Run, blocks: list[Block]) -> None:
    import pandas as pd

    lines = [
        (label, row.label, row.filter, c.key, c.unit, *astuple(v), row.failed, row.runs)
        for label, rows in blocks
        for row in rows
        for c in COLUMNS
        if (v := row.cells.get(c.key)) is not None
    ]
    names = ["condition", "row", "filter", "metric", "unit", "value", "low_95", "high_95"]
    names += ["resampled", "resampled_unit", "note", "runs_failed", "runs"]
    (run.folder / "figures").mkdir(exist_ok=True)
    write_csv(pd.DataFrame(lines, columns=names), run.folder / CSV)
