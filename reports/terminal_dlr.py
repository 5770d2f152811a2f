"""A replay of the DLR log in a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import dissertation, dlr
from reports.run import Run
from reports.terminal import paragraphs, text_table
from reports.wording import number

if TYPE_CHECKING:
    from rich.console import RenderableType

HEADINGS = (
    "RMSE\nm",
    "aligned\nm",
    "max X\nerror²\nm²",
    "max Y\nerror²\nm²",
    "landmarks\nmapped",
    "dupli-\ncates",
    "NEES",
    "association\nprec./recall",
)


def summary(run: Run) -> RenderableType:
    """Our numbers beside the dissertation's."""
    from rich.console import Group

    table = text_table("association\n· observation", HEADINGS)
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
    return Group(table, *paragraphs(notes, "dim"))
