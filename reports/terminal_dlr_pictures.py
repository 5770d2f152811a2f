"""A study of the DLR robot's own pictures in a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import dlr, dlr_pictures
from reports.run import Run
from reports.terminal import paragraphs, text_table
from reports.terminal_dlr import HEADINGS
from reports.wording import number

if TYPE_CHECKING:
    from rich.console import RenderableType


def summary(run: Run) -> RenderableType:
    """Detection of each filter, then SLAM over it."""
    from rich.console import Group

    found = text_table(
        "filter", ("recall\n%", "by pixel\n%", "precision\n%", "range sd\nm", "NEES\n(2 ideal)")
    )
    for name in run.filters:
        d = dlr_pictures.of_filter(run, name)
        shares = [number(100 * s.value, 1) for s in (d.recall, d.recall_by_pixel, d.precision)]
        found.add_row(name, *shares, number(d.range_sd_m, 3), number(d.nees, 2))
    slam = text_table("association\n· observation", HEADINGS)
    failed = []
    for one in dlr.dlr_runs(run):
        slam.add_row(one.label, *([c.ours(one.row) for c in dlr.COLUMNS] if one.ok else ["failed"]))
        if not one.ok:
            failed.append(f"{one.label}: {one.row['status']}")
    return Group(found, slam, *paragraphs(failed, "dim"))
