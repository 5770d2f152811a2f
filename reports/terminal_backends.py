"""Back-ends compared on drives, in a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import backends, dissertation
from reports.run import Run
from reports.terminal import paragraphs, text_table
from reports.wording import number

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

HEADINGS = ("RMSE\nm", "min … max", "ATE\nm", "RPE\nm", "land-\nmarks\nm", "NEES", "ms/step", "MB")
KEYS = ("rmse_m", "", "rmse_aligned_m", "rpe_m", "landmark_rmse_m", "nees", "step_ms", "memory_mb")


def summary(run: Run) -> RenderableType:
    """The verdict, and a table for each drive."""
    from rich.console import Group

    scenes = backends.scenes(run)
    notes = [dissertation.VIRTUAL] if backends.simulates_dissertation(run) else []
    notes += [f"{g.label}: {f}" for scene in scenes for g in backends.groups(run, scene) for f in g.failures]
    tables = [_table(run, scene) for scene in scenes]
    return Group(*paragraphs([backends.verdict(run)], "bold"), *tables, *paragraphs(notes, "dim"))


def _table(run: Run, scene: str) -> Table:
    every = backends.groups(run, scene)
    low, high = backends.nees_band(max(1, *(len(g.rows) for g in every)))
    table = text_table(f"{scene}\nNEES band {low:.2f} … {high:.2f}", HEADINGS)
    columns = {c.key: c for c in backends.COLUMNS}
    for group in every:
        spread = backends.shown(group, columns["rmse_m"])[1]
        cells = [backends.shown(group, columns[key])[0] if key else spread for key in KEYS]
        table.add_row(group.label, *(cells if len(group.rows) else ["failed"]))
    table.add_section()
    table.add_row("Cramér–Rao bound", number(backends.bound_m(run, scene), 3), style="dim")
    if backends.simulates_dissertation(run, scene):
        for published in dissertation.ROWS:
            table.add_row(published.label, number(published.rmse_m, 2), style="dim")
    return table
