"""The headline table as it stands on the page and in ``figures/headline.csv``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, replace

from reports.cases import Case
from reports.page import Cell, Table, TableRow
from reports.run import Run
from reports.style import write_csv
from reports.tables import BASELINE_NOTE, COLUMNS, MARK_NOTE, Column, Row, cell_text, headline, mark

CSV = "figures/headline.csv"
Block = tuple[str, tuple[Row, ...]]


def tables(run: Run, cases: Sequence[Case]) -> tuple[Table, ...]:
    """The first case, which pools all, one number a line; then each further one, one filter a line."""
    told = blocks(run, cases)
    save(run, told)
    by_case = filter_lines("Each illumination", told[1:], COLUMNS, (BASELINE_NOTE,))
    return (_pooled(told[0][1]), replace(by_case, folded=True))


def blocks(run: Run, cases: Sequence[Case]) -> list[Block]:
    """The rows of each case, with its label."""
    return [(case.label, headline(run, case.comparison, case.condition)) for case in cases]


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


def filter_lines(
    caption: str, told: Sequence[Block], columns: Sequence[Column], notes: tuple[str, ...] = ()
) -> Table:
    """One filter a line, a group for each case; the filters that have any of the columns; last, if
    any failed, how many SLAM runs did.
    """
    failed = any(row.failed for _, rows in told for row in rows)
    lines: list[TableRow] = []
    for label, rows in told:
        measured = [row for row in rows if any(c.key in row.cells for c in columns)]
        for i, row in enumerate(measured):
            cells = (*(_cell(c, row) for c in columns), *[Cell(failed_text(row))] * failed)
            lines.append(TableRow(row.label, cells, group=label * (i == 0)))
    head = (*(column.heading for column in columns), *["failed"] * failed)
    return Table(caption, "filter", head, tuple(lines), notes, CSV)


def _cell(column: Column, row: Row) -> Cell:
    return Cell(*cell_text(column, row), mark(column, row))


def failed_text(row: Row) -> str:
    """How many of a row's SLAM runs failed."""
    return f"{row.failed} of {row.runs}" if row.runs else ""


def save(run: Run, told: Sequence[Block]) -> None:
    """Write every number of every case into ``figures/headline.csv``."""
    import pandas as pd

    lines = [
        (label, row.label, row.filter, c.key, c.unit, *astuple(v), row.failed, row.runs)
        for label, rows in told
        for row in rows
        for c in COLUMNS
        if (v := row.cells.get(c.key)) is not None
    ]
    names = ["condition", "row", "filter", "metric", "unit", "value", "low_95", "high_95"]
    names += ["resampled", "resampled_unit", "note", "runs_failed", "runs"]
    (run.folder / "figures").mkdir(exist_ok=True)
    write_csv(pd.DataFrame(lines, columns=names), run.folder / CSV)
