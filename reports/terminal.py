"""A run in a terminal of 100 columns: the verdict and one table."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from reports import dissertation, dlr
from reports.run import Run, load
from reports.wording import NBSP, number

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

COLUMNS_PER_TABLE = 4
DLR_HEADINGS = (
    "RMSE\nm",
    "aligned\nm",
    "max X\nerror²\nm²",
    "max Y\nerror²\nm²",
    "landmarks\nmapped",
    "dupli-\ncates",
    "NEES",
    "association\nprec./recall",
)


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
    return _dlr(run) if run.is_dlr else _rendered(run)


def _rendered(run: Run) -> RenderableType:
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
        table = _table("all illuminations pooled", [row.label for row in shown])
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
    return Group(*_paragraphs(sentences, "bold"), *tables, *_paragraphs(notes, "dim"))


def _cell(value: str, bounds: str, kind: str) -> str:
    """A value, its mark and its interval on one line."""
    arrow = {"better": "▲", "worse": "▼"}.get(kind, "")
    return f"{value}{arrow} {bounds.replace(NBSP, '')}".rstrip()


def _dlr(run: Run) -> RenderableType:
    from rich.console import Group

    table = _table("association\n· observation", DLR_HEADINGS)
    for one in dlr.dlr_runs(run):
        cells = [c.ours(one.row) for c in dlr.COLUMNS] if one.ok else ["failed"]
        table.add_row(one.label, *cells)
    table.add_section()
    for published in dissertation.ROWS:
        table.add_row(published.label, *(c.theirs(published) for c in dlr.COLUMNS), style="dim")
    failed = [f"{one.label}: {one.row['status']}" for one in dlr.dlr_runs(run) if not one.ok]
    notes = [
        dissertation.DIFFERENCE,
        f"Bound for any online estimator: {number(dissertation.BOUND_M)} m. NEES of a consistent filter: 3.",
        *failed,
    ]
    return Group(table, *_paragraphs(notes, "dim"))


def _table(corner: str, headings: Iterable[str]) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(corner)
    for heading in headings:
        table.add_column(heading, justify="right", overflow="fold")
    return table


def _paragraphs(sentences: Iterable[str], style: str) -> list[RenderableType]:
    from rich.padding import Padding
    from rich.text import Text

    return [Padding(Text(s, style=style), (0, 0, 1, 0)) for s in sentences if s]
