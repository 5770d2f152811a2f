"""The page of a study that composites light onto the DLR robot's own pictures."""

from __future__ import annotations

from reports import dlr_light, figures_strips, provenance
from reports.dlr_light import COLUMNS, RECORDED, conditions, row_of
from reports.frame_sums import FrameSums, frame_sums
from reports.kind import Kind
from reports.page import Cell, Page, Section, Table, TableRow
from reports.run import BASELINE, Run
from reports.style import write_csv
from reports.tables import failures
from reports.wording import interval, number

NOTES = (
    "The light is composited: real pictures, to which the specular light of a polished floor was added in "
    "linear light, rendered in the building rebuilt around the drive, at the recorded pose, through the "
    "robot's camera. So the mask is exact and the original known.",
    "“Recorded” are the pictures as they are: what a filter masks or loses there is harm.",
    "Assumed: the camera's encoding is sRGB; the building's own lamps had their nominal light, which ties "
    "the added light to the recorded one. Left out: diffuse light of the added lamps, the exposure that "
    "would follow them, their shot noise, and furniture that would have stood in the light's way.",
    "Recall and precision are against the log's annotated rows, within 0.15 m on the floor. The rows leave "
    "many visible far discs out, so precision is understated for every filter alike.",
    "The original picture, given to the detector, is the best that any repair could reach: compare with "
    "“recorded” without a filter.",
    "▲ better, ▼ worse than no filter on the same pictures, by a paired 95 % interval.",
)


def compose(run: Run) -> Page:
    """Draw the figures and lay out the page."""
    sums = frame_sums(run)
    sections = (
        Section("numbers", "Filters and detector under each light", tables=(table(run, sums),)),
        figures_strips.section(run),
        Section("failures", "Filters that failed", bullets=tuple(f.text for f in failures(run))),
        Section("reading", "How to read this", bullets=NOTES),
    )
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        dlr_light.verdict(run, sums),
        (NOTES[0],),
        tuple(s for s in sections if s.tables or s.strips or s.bullets),
        provenance.lines(run),
    )


def table(run: Run, sums: FrameSums) -> Table:
    """One filter a line under each light; saved as ``figures/dlr-light.csv``."""
    import pandas as pd

    rows, data = [], []
    for light in conditions(run):
        for k, name in enumerate(run.filters):
            numbers = row_of(sums, name, light)
            cells = tuple(
                Cell(
                    number(value.value, c.digits), interval(value, c.digits), "" if name == BASELINE else mark
                )
                for c, (value, mark) in zip(COLUMNS, numbers, strict=True)
            )
            rows.append(TableRow(name, cells, group=light * (k == 0), quiet=name == BASELINE))
            data.append((light, name, *(value.value for value, _ in numbers)))
    head = tuple(c.heading for c in COLUMNS)
    (run.folder / "figures").mkdir(exist_ok=True)
    csv = "figures/dlr-light.csv"
    write_csv(pd.DataFrame(data, columns=["illumination", "filter", *head]), run.folder / csv)
    return Table(f"Pictures {RECORDED} and with light", "filter", head, tuple(rows), (NOTES[-1],), csv)


KIND = Kind(compose, dlr_light.summary, failures)
