"""One back-end over one drive, scored: a row for its online estimate, one more for a smoothed track."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench import g2o
from bench.metrics import landmarks, trajectory
from bench.run_facts import empty_run_row
from bench.sequences.drive import Drive
from vslam.errors import VslamError
from vslam.slam import SlamResult, SlamSettings, run_slam

FloatArray = NDArray[np.float64]
SMOOTHED = "_smoothed"
"""Ends the label of a smoothed track's row."""


@dataclass(frozen=True, eq=False)
class Replay:
    """One estimate of a drive.

    Attributes
    ----------
    row : dict
        Row of the runs table, exactly `bench.schema.RUN_COLUMNS`; ``status`` tells whether the run failed.
    poses : (n, 3) float64
        Estimated x, y (metres) and heading (rad) after each step; empty if the run failed.
    truth : (n, 3) float64
        The true poses beside them.
    landmark_table : (k, 5) float64
        Known id, true x and y, estimated x and y (metres): every known landmark, NaN where not mapped,
        further rows for duplicates; id −1 with NaN truth for estimates that no known observation supports.
    seconds : float
        Wall clock of the SLAM run; NaN if it failed.
    graph : str
        The run as a g2o file (`bench.g2o`); empty if it failed.
    """

    row: dict[str, object]
    poses: FloatArray
    truth: FloatArray
    landmark_table: FloatArray
    seconds: float
    graph: str = ""


def run_and_score(
    drive: Drive, settings: SlamSettings, label: str, seed: int, bound_m: float = math.nan
) -> tuple[Replay, ...]:
    """Run a back-end over a drive.

    Parameters
    ----------
    drive : Drive
    settings : SlamSettings
    label : str
        Of the back-end, for the rows.
    seed : int
        Number of the repetition, for the rows.
    bound_m : float
        `bench.metrics.cramer_rao.position_bound`, where it is known.

    Returns
    -------
    tuple of Replay
        The online estimate; after it the smoothed one of a back-end that smooths. A run that breaks down is a
        row whose status says why, not an exception.
    """
    row = _empty_row(drive, settings, label, seed) | {"bound_m": bound_m}
    try:
        result = run_slam(drive.steps, settings)
    except VslamError as error:
        failed = row | {"status": f"failed: {error}"}
        return (Replay(failed, np.zeros((0, 3)), drive.truth, np.zeros((0, 5)), math.nan),)
    row["step_ms"] = 1e3 * result.seconds / max(len(drive.steps), 1)
    row["memory_mb"] = result.memory_bytes / 1e6
    replays = [_scored(drive, result, row, result.poses, result.landmarks, result.covariances)]
    if result.smoothed is not None:
        hindsight = row | {
            "backend": label + SMOOTHED,
            "bound_m": math.nan,  # it is that of online estimators
            "step_ms": math.nan,
            "memory_mb": math.nan,
        }
        smoothed = result.smoothed
        replays.append(_scored(drive, result, hindsight, smoothed.poses, smoothed.landmarks, None))
    return tuple(replays)


def _scored(
    drive: Drive,
    result: SlamResult,
    row: dict[str, object],
    poses: FloatArray,
    estimated: FloatArray,
    covariances: FloatArray | None,
) -> Replay:
    track = trajectory.evaluate(poses, drive.truth, covariances)
    marks = landmarks.evaluate(
        estimated, result.matches, drive.seen, drive.landmark_positions, unlabelled=True
    )
    row = row | vars(track) | vars(marks) | {"status": "ok"}
    table = landmarks.table(estimated, result.matches, drive.seen, drive.landmark_positions, unlabelled=True)
    known = table[:, 0] >= 0
    table[known, 0] = drive.landmark_ids[table[known, 0].astype(np.int64)]
    graph = g2o.text(drive.steps, result.matches, poses, estimated)
    return Replay(row, poses, drive.truth, table, result.seconds, graph)


def _empty_row(drive: Drive, settings: SlamSettings, label: str, seed: int) -> dict[str, object]:
    """A runs row in which every metric is still empty."""
    return empty_run_row() | {
        "scene": drive.name,
        "illumination": "recorded",
        "filter": "none",
        "backend": label,
        "association": settings.association,
        "observation": settings.observation,
        "seed": seed,
        "steps": len(drive.steps),
        "landmarks_total": len(drive.landmark_ids),
    }
