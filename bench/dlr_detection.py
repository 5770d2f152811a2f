"""How detections in the real pictures are scored: against the log's rows, and against its map.

Recall asks for the annotated rows of the step: each has a detection within `GATE_M` on the floor, one to one.
The rows lie where the log's own calibration puts them, which is biased (`bench.sequences.dlr_mount`); so a
second recall looks at the rows' pixels through the calibration in use.

Precision asks for the map: a detection is true within `GATE_M` of a mapped disc, as the least-squares pose of
the step sees it. The rows would not do: the log leaves many visible far discs out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.metrics.detection import match
from bench.sequences.dlr_pictures import on_picture
from vslam.camera import Calibration
from vslam.frame import Observations

FloatArray = NDArray[np.float64]

GATE_M = 0.15


@dataclass(frozen=True, eq=False)
class Scores:
    """One picture's.

    Attributes
    ----------
    annotated, found, found_by_pixel : int
        The step's annotated rows, and those with a detection: at the row, and at the row's pixel.
    detected, true : int
        Detections, and those within the gate of a mapped disc that no nearer detection has.
    disc : (n,) int64
        Mapped disc of each detection (row of the map), or −1.
    errors : (p, 5) float64
        Of each true detection: distance (m) and bearing (rad) of its disc, error of distance (m) and of
        bearing (rad), and the error's squared Mahalanobis distance (χ²₂: 2 on average if consistent).
    """

    annotated: int
    found: int
    found_by_pixel: int
    detected: int
    true: int
    disc: NDArray[np.int64]
    errors: FloatArray


def score(
    seen: Observations, rows: Observations, mapped: FloatArray, view: Calibration, log_view: Calibration
) -> Scores:
    """Score the detections of one picture.

    Parameters
    ----------
    seen : Observations
        Detections.
    rows : Observations
        The log's; those without an annotated id (−1) are left out.
    mapped : (m, 2) float64
        All discs, robot frame, metres.
    view, log_view : Calibration
        In use, and the one that fits the log's rows.
    """
    annotated = rows.points[rows.ids >= 0]
    through, _ = view.floor_points(on_picture(log_view, annotated))
    through = through[np.isfinite(through).all(axis=1)]
    pairs = match(seen.points, mapped, GATE_M)
    disc = np.full(len(seen), -1, dtype=np.int64)
    disc[pairs[:, 0]] = pairs[:, 1]
    return Scores(
        len(annotated),
        len(match(annotated, seen.points, GATE_M)),
        len(match(through, seen.points, GATE_M)),
        len(seen),
        len(pairs),
        disc,
        _errors(seen.points[pairs[:, 0]], seen.covariances[pairs[:, 0]], mapped[pairs[:, 1]]),
    )


def _errors(points: FloatArray, covariances: FloatArray, discs: FloatArray) -> FloatArray:
    ranges, bearings = np.hypot(*discs.T), np.arctan2(discs[:, 1], discs[:, 0])
    error = points - discs
    turned = np.arctan2(points[:, 1], points[:, 0]) - bearings
    squared = np.einsum("ni,ni->n", error, np.linalg.solve(covariances, error[..., None])[..., 0])
    return np.column_stack(
        [ranges, bearings, np.hypot(*points.T) - ranges, (turned + np.pi) % (2 * np.pi) - np.pi, squared]
    )
