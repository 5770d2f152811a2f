"""The page of back-ends compared on drives."""

from __future__ import annotations

import numpy as np

from reports import backends, dissertation, figures_backends, provenance, terminal_backends
from reports.kind import Kind
from reports.page import Cell, Page, Picture, Section, Table, TableRow
from reports.run import Run
from reports.style import write_csv
from reports.tables import failures
from reports.wording import number

BOUND = "Cramér–Rao bound, any online estimator"

CAVEATS = (
    "RMSE is that of position (3-39) without any alignment: the filter starts at the first pose with no "
    "uncertainty. ATE is after the best rotation and shift of the whole estimated path; RPE compares motions "
    "over ten steps.",
    "Below a mean stands the smallest and the largest repetition. A recorded drive has one.",
    "The posterior Cramér–Rao bound takes the covariances that the stream states, at the true track. "
    "Estimators that are no longer unbiased, and single runs, may fall below it.",
    "NEES is the mean over steps and repetitions. The band printed with each table is that of the mean over "
    "its repetitions at one step, for a consistent filter.",
    "Rows named …_smoothed know the whole drive: no online estimate, so neither bound nor time stands beside "
    "them.",
    "Milliseconds are measured while other processes run. Memory counts the numbers of the estimate (for the "
    "graph those of the Bayes tree alone).",
)


def compose(run: Run) -> Page:
    """Draw the figures and lay out the page."""
    scenes = backends.scenes(run)
    fed = backends.truth_fed(run)
    further = [dissertation.VIRTUAL] if backends.simulates_dissertation(run) else []
    if fed:
        further.append(
            f"The odometry of {', '.join(fed)} was fed by the truth (odometry: truth_fed): those errors are "
            "no robot's."
        )
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        backends.verdict(run),
        tuple(further),
        (
            *(
                Section(
                    f"drive-{scene}",
                    f"Drive {scene}",
                    tables=(table(run, scene),),
                    pictures=_pictures(run, scene),
                )
                for scene in scenes
            ),
            Section("reading", "How to read this", bullets=CAVEATS),
        ),
        provenance.lines(run),
    )


def table(run: Run, scene: str) -> Table:
    """Back-ends on a drive, the bound, and the published results; ``figures/backends--<scene>.csv``."""
    import pandas as pd

    every = backends.groups(run, scene)
    rows = [_row(group) for group in every]
    bound = backends.bound_m(run, scene)
    empty = (Cell(),) * (len(backends.COLUMNS) - 1)
    if np.isfinite(bound):
        rows.append(TableRow(BOUND, (Cell(number(bound, 3)), *empty), quiet=True))
    if backends.simulates_dissertation(run, scene):
        rows += [
            TableRow(p.label, (Cell(number(p.rmse_m, 2)), *empty), p.source, quiet=True)
            for p in dissertation.ROWS
        ]
    head = tuple(c.title for c in backends.COLUMNS)
    data = [(r.label, *(f"{c.value} {c.interval}".strip() for c in r.cells), r.note) for r in rows]
    name = f"backends--{scene}.csv"
    write_csv(pd.DataFrame(data, columns=["back-end", *head, "note"]), run.folder / "figures" / name)
    repetitions = max((len(g.rows) for g in every), default=0)
    notes: tuple[str, ...] = ()
    if repetitions:
        low, high = backends.nees_band(repetitions)
        notes = (f"95 % band of the NEES for {repetitions} repetition(s): {low:.2f} … {high:.2f}.",)
    return Table(f"Back-ends on {scene}", "back-end", head, tuple(rows), notes, f"figures/{name}")


def _row(group: backends.Group) -> TableRow:
    note = f"failed {len(group.failures)} x: {group.failures[0]}" if group.failures else ""
    return TableRow(group.label, tuple(Cell(*backends.shown(group, c)) for c in backends.COLUMNS), note)


def _pictures(run: Run, scene: str) -> tuple[Picture, ...]:
    if not any(len(g.rows) for g in backends.groups(run, scene)):
        return ()
    return (
        Picture(
            figures_backends.draw_spread(run, scene),
            "Position error of every repetition",
            "The spread between repetitions of the same noise is what a single published number hides.",
        ),
    )


KIND = Kind(compose, terminal_backends.summary, failures, filtered=False)
