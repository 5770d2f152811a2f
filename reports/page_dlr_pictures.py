"""The page of a study of the DLR robot's own pictures."""

from __future__ import annotations

from reports import dlr, dlr_pictures, figures_dlr_pictures, figures_map, provenance, terminal_dlr_pictures
from reports.kind import Kind
from reports.page import Cell, Page, Picture, Section, Table, TableRow
from reports.page_dlr import runs_table
from reports.run import BASELINE, Run
from reports.statistics import Estimate
from reports.tables import failures
from reports.wording import interval, number

REAL = (
    "The pictures are real, and nothing is drawn into them: one PAL field each, grey, rows half as dense as "
    "columns. They hold little glare; light filters meet white walls, lit floors and white discs here.",
    "Recall asks for the log's annotated rows, precision for its least-squares map: the rows leave many "
    "visible far discs out. Either counts within 0.15 m on the floor. What precision calls false is, in the "
    "pictures looked at, mostly a real disc that the map has elsewhere or not at all; reflections in glass "
    "doors and shadows are the rest.",
    "The log's rows have biased ranges (4 cm too far at 1.5 m, 9 cm too near at 3.5 m, against their own "
    "map), and camera.json was fitted to them. So the mount is calibrated on the map, on pictures that no "
    "score counts. “By pixel” looks for the rows where the picture shows them, through that mount.",
    "The reference track is the least-squares fit of the log's own rows, outliers and bias too. "
    "Those very rows, smoothed with a robust loss, end 0.4 m from it: a smaller RMSE says more "
    "about shared errors than about the robot's place.",
    "Annotated association takes the id of the mapped disc that a detection lies on (within 0.15 m).",
    "A grey picture has no chromaticity: a filter that separates by colour masks much of it and repairs "
    "nothing.",
)


def compose(run: Run) -> Page:
    """Draw the figures and lay out the page."""
    maps = (figures_map.draw_dlr(run, scene) for scene in run.scenes) if _any_ok(run) else ()
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        verdict(run),
        (_frames(run),),
        (
            Section("detection", "What the detector finds", tables=(_detection_table(run),)),
            Section("pictures", "In the pictures", pictures=_pictures(run)),
            Section(
                "slam",
                "SLAM over what was found",
                tables=(runs_table(run, "SLAM over detections in the real pictures", "dlr-pictures-runs"),),
                pictures=tuple(
                    Picture(path, "Map with path and landmarks", "One panel for each run.")
                    for path in maps
                    if path
                ),
            ),
            Section("reading", "How to read this", bullets=REAL),
        ),
        provenance.lines(run),
    )


def verdict(run: Run) -> str:
    """One sentence: recall and precision on raw pictures."""
    raw = dlr_pictures.of_filter(run, BASELINE)
    return (
        f"In the raw pictures our detector finds {_percent(raw.recall)} of the log's annotated discs, and "
        f"{_percent(raw.precision)} of what it reports lies on a mapped disc."
    )


def _frames(run: Run) -> str:
    count, every = run.frames["frame"].nunique(), int(run.study.get("calibrate_every", 0))
    stride = int(run.study.get("stride", 1))
    taken = f" (every {stride}th of the log's)" if stride > 1 else ""
    left_out = f"; pictures 0, {every}, {2 * every} … calibrate the camera's mount instead" if every else ""
    return f"{count:,} recorded pictures are scored{taken}{left_out}."


def _any_ok(run: Run) -> bool:
    return any(one.ok for one in dlr.dlr_runs(run))


def _percent(value: Estimate) -> str:
    shown = f"{number(100 * value.value, 1)} %"
    return f"{shown} ({interval(value, 1, scale=100)})" if value.has_interval else shown


def _detection_table(run: Run) -> Table:
    head = (
        "recall of annotated rows, %",
        "recall by pixel, %",
        "precision, %",
        "detections",
        "range error, m",
        "bearing error, °",
        "NEES (2 ideal)",
        "filter, ms",
    )
    rows = []
    for name in run.filters:
        d = dlr_pictures.of_filter(run, name)
        shares = [
            Cell(number(100 * s.value, 1), interval(s, 1, scale=100) if s.has_interval else "")
            for s in (d.recall, d.recall_by_pixel, d.precision)
        ]
        degrees = 57.29577951308232
        bearing = f"{number(degrees * d.bearing_bias_rad, 3)} ± {number(degrees * d.bearing_sd_rad, 2)}"
        rest = (
            f"{d.detected:,}",
            f"{number(d.range_bias_m, 3)} ± {number(d.range_sd_m, 3)}",
            bearing,
            number(d.nees, 2),
            number(d.filter_ms, 2),
        )
        rows.append(TableRow(name, (*shares, *(Cell(text) for text in rest))))
    return Table(
        "Detection on pictures that chose nothing",
        "filter",
        head,
        tuple(rows),
        ("Errors are mean ± standard deviation of true detections against the map.",),
        "figures/dlr-pictures.csv",
    )


def _pictures(run: Run) -> tuple[Picture, ...]:
    rings = "Green: on a mapped disc; red: on none; thin yellow: the log's annotated rows."
    sheets = (
        Picture(figures_dlr_pictures.draw_sheet(run, name), f"Found with the filter {name}", rings)
        for name in run.filters
    )
    errors = Picture(
        figures_dlr_pictures.draw_errors(run, BASELINE),
        "Errors of range and bearing over distance",
        "Median, quartiles, 5th and 95th percentile of true detections in raw pictures.",
    )
    return (*sheets, errors)


KIND = Kind(compose, terminal_dlr_pictures.summary, failures)
