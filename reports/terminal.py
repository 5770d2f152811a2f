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
    if run.compares_drives:
        return _drives(run)
    return _dlr(run) if run.is_dlr else _rendered(run)


def _rendered(run: Run) -> RenderableType:
    from rich.console import Group

    from reports.comparison import compare
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
        *(f"failed: {f.filter}, {f.count} x: {f.reason}" for f in failures(run)),
    ]
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
        f"Bound for any online estimator: {number(dlr.bound_m(run), 2)} m. NEES of a consistent filter: 3.",
        *failed,
    ]
    return Group(table, *_paragraphs(notes, "dim"))


def _drives(run: Run) -> RenderableType:
    from rich.console import Group

    from reports import drives

    tables = []
    for scene in drives.scenes(run):
        every = drives.groups(run, scene)
        low, high = drives.nees_band(max(1, *(len(g.rows) for g in every)))
        headings = ("RMSE\nm", "min … max", "ATE\nm", "RPE\nm", "land-\nmarks\nm", "NEES", "ms/step", "MB")
        table = _table(f"{scene}\nNEES band {low:.2f} … {high:.2f}", headings)
        keys = ("rmse_m", "", "rmse_aligned_m", "rpe_m", "landmark_rmse_m", "nees", "step_ms", "memory_mb")
        columns = {c.key: c for c in drives.COLUMNS}
        for group in every:
            spread = drives.shown(group, columns["rmse_m"])[1]
            cells = [drives.shown(group, columns[k])[0] if k else spread for k in keys]
            table.add_row(group.label, *(cells if len(group.rows) else ["failed"]))
        table.add_section()
        table.add_row("Cramér–Rao bound", number(drives.bound_m(run, scene), 3), style="dim")
        if drives.simulates_dissertation(run, scene):
            for published in dissertation.ROWS:
                table.add_row(published.label, number(published.rmse_m, 2), style="dim")
        tables.append(table)
    notes = [dissertation.VIRTUAL] if drives.simulates_dissertation(run) else []
    failed = [
        f"{g.label}: {f}" for s in drives.scenes(run) for g in drives.groups(run, s) for f in g.failures
    ]
    return Group(*_paragraphs([drives.verdict(run)], "bold"), *tables, *_paragraphs([*notes, *failed], "dim"))


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
