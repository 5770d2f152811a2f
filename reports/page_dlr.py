"""The page of a replay of the DLR log."""

from __future__ import annotations

from reports import dissertation, dlr, figures_dlr, figures_map, provenance, terminal_dlr
from reports.kind import Kind
from reports.page import Cell, Page, Picture, Section, Table, TableRow
from reports.run import Run
from reports.style import write_csv
from reports.tables import failures
from reports.wording import number

CAVEATS = (
    "RMSE is that of position (3-39) without any alignment: the filter starts at the log's first pose with "
    "no uncertainty. The aligned value is after the best rotation and shift of the whole estimated path, "
    "and says how good its shape is.",
    "NEES is the normalised estimation error squared of the robot's pose: 3 on average for a consistent "
    "filter; far above it, the filter is surer than it should be.",
    "Landmarks mapped counts distinct annotated landmarks; a landmark mapped a second time is a duplicate "
    "and is counted apart.",
    "One log is one sample and EKF-SLAM has no random part, so no interval is given: there is nothing here "
    "to resample. EKF-SLAM is inconsistent on loops this long, so small details move these numbers.",
    "The posterior Cramér–Rao bound is that of any online estimator with the log's own covariances and its "
    "annotated ids, at the reference track. A smoothed track knows the whole drive and is not bound by it.",
)


def compose(run: Run) -> Page:
    """Draw the figures and lay out the page."""
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        dlr.verdict(run),
        (dissertation.DIFFERENCE,),
        (
            Section("numbers", "Our numbers beside the dissertation's", tables=(table(run),)),
            Section("figures", "Over the log", pictures=_pictures(run)),
            Section("reading", "How to read this", bullets=CAVEATS),
        ),
        provenance.lines(run),
    )


def table(run: Run) -> Table:
    """Runs over the log, then the bound and the published results; saved as ``figures/dlr-table.csv``."""
    cells = (Cell(number(dlr.bound_m(run), 3)), *(Cell() for _ in dlr.COLUMNS[1:]))
    bound = TableRow("Cramér–Rao bound, any online estimator", cells, quiet=True)
    published = [
        TableRow(p.label, tuple(Cell(c.theirs(p)) for c in dlr.COLUMNS), p.source, quiet=True)
        for p in dissertation.ROWS
    ]
    return runs_table(run, "EKF-SLAM over the DLR building log", "dlr-table", (bound, *published))


def runs_table(run: Run, caption: str, name: str, further: tuple[TableRow, ...] = ()) -> Table:
    """One row per run, then further ones; saved as ``figures/<name>.csv``."""
    import pandas as pd

    rows = (*(_row(one) for one in dlr.dlr_runs(run)), *further)
    head = tuple(c.title for c in dlr.COLUMNS)
    data = [(r.label, *(c.value for c in r.cells), r.note) for r in rows]
    write_csv(pd.DataFrame(data, columns=["run", *head, "note"]), run.folder / "figures" / f"{name}.csv")
    return Table(caption, "association · observation", head, rows, csv=f"figures/{name}.csv")


def _row(one: dlr.DlrRun) -> TableRow:
    if not one.ok:
        return TableRow(one.label, tuple(Cell() for _ in dlr.COLUMNS), str(one.row["status"]))
    return TableRow(one.label, tuple(Cell(c.ours(one.row)) for c in dlr.COLUMNS))


def _pictures(run: Run) -> tuple[Picture, ...]:
    if not any(one.ok for one in dlr.dlr_runs(run)):
        return ()
    maps = (figures_map.draw_dlr(run, scene) for scene in run.scenes)
    return (
        Picture(
            figures_dlr.draw_squared_error(run),
            "Squared error of each axis over iterations",
            "Equations 3-40 and 3-41, on a logarithmic axis. Dashed: the largest value the dissertation "
            "reports for its simulated sensor (its figures 4-3A and 4-3B).",
        ),
        Picture(
            figures_dlr.draw_coordinates(run),
            "Position over iterations, true and estimated",
            "The dissertation's figures 4-2A and 4-2B. “True” is the log's reference track.",
        ),
        *(
            Picture(
                path,
                "Map with path and landmarks",
                "The dissertation's figure 4-1A, one panel for each run. Rings are the annotated landmarks, "
                "dots what the filter mapped; duplicates are drawn too.",
            )
            for path in maps
            if path
        ),
        Picture(
            figures_dlr.draw_mapped(run),
            "Share of landmarks mapped",
            "The dissertation's figure 4-1C. Duplicates do not count as mapped; they are outlined on top.",
        ),
    )


KIND = Kind(compose, terminal_dlr.summary, failures, filtered=False)
