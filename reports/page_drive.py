"""The page of a study in closed loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from reports import figures_closed_loop, provenance
from reports.closed_loop import (
    EXPLORE,
    GOAL,
    discordant,
    drives,
    failures,
    mean,
    outcomes,
    recall,
    share,
    titles,
    verdict,
)
from reports.kind import Kind
from reports.page import Cell, Page, Picture, Section, Table, TableRow
from reports.run import BASELINE, Run
from reports.statistics import CONFIDENCE, Estimate
from reports.style import write_csv
from reports.terminal import of_table, paragraphs
from reports.wording import interval, number

if TYPE_CHECKING:
    from pandas import DataFrame
    from rich.console import RenderableType

Column = tuple[str, Callable[["DataFrame"], Estimate], int, float, tuple[str, ...]]
COLUMNS: tuple[Column, ...] = (
    ("success, %", lambda rows: share(rows, "success"), 0, 100.0, (GOAL, EXPLORE)),
    ("SPL", lambda rows: mean(rows, "spl"), 3, 1.0, (GOAL,)),
    ("free space explored, %", lambda rows: mean(rows, "explored"), 1, 100.0, (EXPLORE,)),
    ("collisions, %", lambda rows: share(rows, "collision"), 0, 100.0, (GOAL, EXPLORE)),
    ("largest position error, m", lambda rows: mean(rows, "error_max_m"), 3, 1.0, (GOAL, EXPLORE)),
    ("landmark recall, %", recall, 1, 100.0, (GOAL, EXPLORE)),
    ("time, s", lambda rows: mean(rows, "seconds"), 0, 1.0, (GOAL, EXPLORE)),
    ("new plans", lambda rows: mean(rows, "replans"), 1, 1.0, (GOAL, EXPLORE)),
)

CAVEATS = (
    "Success of a drive to the goal: wherever the robot believes to have arrived, at the goal and then at"
    " home, it truly is within the study's arrival distance, and it has touched nothing. Lost: it "
    "believed to have arrived and was elsewhere. Stuck: its own map has no way, and looking around once "
    "opened none.",
    "SPL is success weighted by path length (Anderson et al. 2018). The shortest way is what the robot's "
    "own planner finds on the true map, which it does not know.",
    "Success of exploring: no frontier is left that can be reached, before time is up and without "
    "touching anything; how much was seen stands beside it, as share of the free cells that the robot's "
    "map holds for free.",
    "Intervals of shares are Wilson's, of means a bootstrap over drives. Filters meet the same starts, "
    "goals and random streams, so they are compared drive by drive (McNemar's exact test).",
    "The robot moves as commanded plus the study's noise, and its odometry reports the command; it stops "
    "and turns at once. It is given its start and the goal in one frame, and the extent of the place.",
    "Where blocks of pixels agree they share shadow rays: a robot waits for its picture. In the scene "
    "corridor at most one pixel in a thousand differs by more than 8 grey levels from the pictures of other "
    "studies.",
)


def compose(run: Run) -> Page:
    """Count, draw and lay out the page."""
    own = drives(run)
    sections = [
        Section(task, title, tables=(table(run, task),), pictures=_pictures(run, task))
        for task, (title, _) in titles(run).items()
        if own.has(task)
    ]
    sections.append(Section("reading", "How to read this", bullets=CAVEATS))
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        verdict(run),
        (),
        tuple(sections),
        provenance.lines(run),
    )


def table(run: Run, task: str) -> Table:
    """Light × filter, all lights pooled first; saved as ``figures/drive-<task>.csv``."""
    import pandas as pd

    own, rows, data = drives(run), [], []
    columns = [c for c in COLUMNS if task in c[-1]]
    head = (*(c[0] for c in columns), "did not succeed")
    for label, light in (("all lights", None), *((light.label, light.name) for light in own.lights)):
        for i, name in enumerate(own.filters):
            drawn = own.of(task, name, light)
            cells = [_cell(measure(drawn), digits, scale) for _, measure, digits, scale, _ in columns]
            if name != BASELINE:
                cells[0] = _marked(cells[0], *discordant(own, name, task, light))
            rows.append(
                TableRow(
                    name, (*cells, Cell(outcomes(drawn))), f"{len(drawn)} drives", group=label * (i == 0)
                )
            )
            data.append((label, name, *(f"{c.value} {c.interval}".strip() for c in cells), outcomes(drawn)))
    csv = f"figures/drive-{task}.csv"
    write_csv(pd.DataFrame(data, columns=["light", "filter", *head]), run.folder / csv)
    return Table(titles(run)[task][0], "filter", head, tuple(rows), csv=csv)


def _cell(value: Estimate, digits: int, scale: float) -> Cell:
    return Cell(number(scale * value.value, digits), interval(value, digits, scale=scale))


def _marked(cell: Cell, gained: int, lost: int, p: float) -> Cell:
    mark = "" if p >= 1 - CONFIDENCE else ("better" if gained > lost else "worse")
    return Cell(cell.value, cell.interval, mark)


def _pictures(run: Run, task: str) -> tuple[Picture, ...]:
    pictures = [
        Picture(
            figures_closed_loop.draw_success(run, task),
            "Share of drives that succeeded",
            "Dots with Wilson's 95 % intervals.",
        )
    ]
    path = figures_closed_loop.draw_map(run, task)
    if path is not None:
        pictures.append(
            Picture(path, "Where the robot was, and where it believed to be", figures_closed_loop.PLACE_RULE)
        )
    curves = figures_closed_loop.draw_exploration(run) if task == EXPLORE else None
    if curves is not None:
        pictures.append(Picture(curves, "Free space explored over time", "A line for each drive."))
    return tuple(pictures)


def summary(run: Run) -> RenderableType:
    """The verdict and a table for each task."""
    from rich.console import Group

    own, tables = drives(run), []
    for task in titles(run):
        if not own.has(task):
            continue
        tables.append(of_table(table(run, task)))
    return Group(*paragraphs([verdict(run)], "bold"), *tables)


KIND = Kind(compose, summary, failures, filtered=False)
