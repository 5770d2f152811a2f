"""Detection in the DLR robot's own pictures: recall, precision and errors of each filter."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from reports.errors import ReportError
from reports.run import Run
from reports.statistics import Estimate, estimate, ratio

if TYPE_CHECKING:
    from pandas import DataFrame

BLOCK_STEPS = 50
"""Neighbouring pictures show the same discs: intervals resample blocks of 50 steps, some 8 m of the drive."""

PICTURES = ("frame", "filter", "annotated", "found", "found_by_pixel", "detected", "true")
DETECTIONS = (
    "frame",
    "filter",
    "range_m",
    "bearing_rad",
    "range_error_m",
    "bearing_error_rad",
    "squared_mahalanobis",
)


@dataclass(frozen=True)
class Detection:
    """One filter's numbers over all scored pictures.

    Attributes
    ----------
    recall, recall_by_pixel, precision : Estimate
        Shares; see `bench.dlr_detection`.
    range_bias_m, range_sd_m, bearing_bias_rad, bearing_sd_rad : float
        Of true detections.
    nees : float
        Mean of the squared Mahalanobis distance: 2 for a consistent covariance.
    """

    recall: Estimate
    recall_by_pixel: Estimate
    precision: Estimate
    range_bias_m: float
    range_sd_m: float
    bearing_bias_rad: float
    bearing_sd_rad: float
    nees: float
    detected: int
    filter_ms: float


def detections(run: Run) -> DataFrame:
    """``figures/dlr-detections.csv``: one row per true detection."""
    return _csv(run.folder / "figures" / "dlr-detections.csv", DETECTIONS)


def pictures(run: Run) -> DataFrame:
    """``figures/dlr-pictures.csv``: one row per scored picture and filter."""
    return _csv(run.folder / "figures" / "dlr-pictures.csv", PICTURES)


def of_filter(run: Run, name: str) -> Detection:
    """Sum a filter's pictures up."""
    rows, errors = pictures(run), detections(run)
    rows, errors = rows[rows["filter"] == name], errors[errors["filter"] == name]
    sums = rows.groupby(rows["frame"] // BLOCK_STEPS).sum(numeric_only=True)
    distance, bearing = errors["range_error_m"], errors["bearing_error_rad"]
    times = run.frames.loc[run.frames["filter"] == name, "filter_ms"]
    return Detection(
        _share(sums["found"], sums["annotated"]),
        _share(sums["found_by_pixel"], sums["annotated"]),
        _share(sums["true"], sums["detected"]),
        float(distance.mean()),
        float(distance.std()),
        float(bearing.mean()),
        float(bearing.std()),
        float(errors["squared_mahalanobis"].mean()),
        int(rows["detected"].sum()),
        float(times.median()),
    )


def error_by_range(run: Run, name: str) -> DataFrame:
    """Percentiles of distance and bearing error per half metre of distance."""
    import pandas as pd

    rows = detections(run)
    rows = rows[rows["filter"] == name]
    parts = []
    for near in np.arange(0.5, 5.0, 0.5):
        here = rows[(rows["range_m"] >= near) & (rows["range_m"] < near + 0.5)]
        if len(here) < 20:
            continue
        row: dict[str, object] = {"filter": name, "range_m": near + 0.25, "detections": len(here)}
        for percent in (5, 25, 50, 75, 95):
            row[f"range_error_p{percent}_m"] = np.percentile(here["range_error_m"], percent)
            row[f"bearing_error_p{percent}_deg"] = np.degrees(
                np.percentile(here["bearing_error_rad"], percent)
            )
        parts.append(row)
    return pd.DataFrame(parts)


def _share(part: ArrayLike, whole: ArrayLike) -> Estimate:
    return estimate(ratio, np.array([part, whole], dtype=np.float64), "blocks")


def _csv(path: Path, columns: tuple[str, ...]) -> DataFrame:
    import pandas as pd

    try:
        table = pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise ReportError(f"{path} is missing or damaged: run the study again") from error
    if tuple(table.columns) != columns:
        raise ReportError(f"{path} has other columns than {', '.join(columns)}: run the study again")
    return table
