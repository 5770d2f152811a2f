"""Strips: raw, true mask, predicted mask, repaired and true diffuse picture of a few frames."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reports.errors import ReportError
from reports.illuminations import COLUMNS as COLUMNS_OF_LIGHT
from reports.illuminations import Illumination
from reports.run import BASELINE, Run, records
from reports.tracks import read_csv

PICTURES = {
    "raw": "raw",
    "true_mask": "true mask",
    "predicted_mask": "predicted mask",
    "repaired": "repaired",
    "true_diffuse": "true diffuse",
}
COLUMNS = ("scene", "illumination", "filter", "frame", "rank", "iou", "psnr_db", *PICTURES)
RANKS = ("best", "median", "worst")
Labels = dict[tuple[str, str], str]
PNG = b"\x89PNG\r\n\x1a\n"
BUDGET_BYTES = 3_500_000
"""Of PNG on the page: base64 adds a third, and the page must stay far below 8 MB."""


@dataclass(frozen=True, eq=False)
class Strip:
    """One frame under one filter.

    Attributes
    ----------
    filter, rank, light : str
    frame : int
    iou, psnr_db : float
    files : dict
        Kind of picture → path.
    """

    filter: str
    rank: str
    light: str
    frame: int
    iou: float
    psnr_db: float
    files: dict[str, Path]


def strips(run: Run) -> tuple[tuple[Strip, ...], int]:
    """The strips that fit on a page, and how many the run stored.

    Filter by filter, the baseline last, best before worst; what does not fit is left out from the end.

    Raises
    ------
    ReportError
        A listed picture is missing or no PNG.
    """
    path = run.folder / "figures" / "strips.csv"
    if not path.exists():
        return (), 0
    rows = records(read_csv(path, COLUMNS))
    labels = _lights(run)
    rows.sort(key=lambda row: _order(row, run))
    chosen: list[Strip] = []
    spent = 0
    for row in rows:
        strip = _strip(row, run.folder / "figures" / "strips", labels)
        spent += sum(file.stat().st_size for file in strip.files.values())
        if chosen and spent > BUDGET_BYTES:
            break
        chosen.append(strip)
    return tuple(chosen), len(rows)


def _lights(run: Run) -> Labels:
    """What each light is called, by scene and name: a study of several scenes has its own in each."""
    several = len(run.scenes) > 1
    rows = records(run.frames[["scene", *COLUMNS_OF_LIGHT]].drop_duplicates())
    return {
        (str(row["scene"]), str(row["illumination"])): f"{row['scene']}, " * several
        + Illumination.of(row).label
        for row in rows
    }


def _order(row: dict[str, Any], run: Run) -> tuple[Any, ...]:
    name, rank = str(row["filter"]), str(row["rank"])
    position = run.filters.index(name) if name in run.filters else len(run.filters)
    return (
        name == BASELINE,
        position,
        RANKS.index(rank) if rank in RANKS else len(RANKS),
        str(row["illumination"]),
        int(row["frame"]),
    )


def _strip(row: dict[str, Any], folder: Path, labels: Labels) -> Strip:
    files = {kind: folder / str(row[kind]) for kind in PICTURES}
    for file in files.values():
        _check(file)
    name = str(row["illumination"])
    place = str(row["scene"])
    return Strip(
        str(row["filter"]),
        str(row["rank"]),
        labels.get((place, name), name),
        int(row["frame"]),
        float(row["iou"]),
        float(row["psnr_db"]),
        files,
    )


def _check(file: Path) -> None:
    try:
        with file.open("rb") as stream:
            head = stream.read(len(PNG))
    except OSError as error:
        raise ReportError(f"{file} is missing: run the study again") from error
    if head != PNG:
        raise ReportError(f"{file} is no PNG picture: run the study again")
