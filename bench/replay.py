"""SLAM over the recorded DLR log, scored: once per association and observation form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.metrics import landmarks, trajectory
from bench.run_facts import empty_run_row
from bench.sequences.dlr import DlrLog
from vslam.errors import VslamError
from vslam.motion import move
from vslam.slam import SlamResult, SlamSettings, run_slam

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Replay:
    """One run over the log.

    Attributes
    ----------
    row : dict
        Row of the runs table, exactly `bench.schema.RUN_COLUMNS`; ``status`` tells whether the run failed.
    poses : (n, 3) float64
        Estimated x, y (metres) and heading (rad) after each step; empty if the run failed.
    truth : (n, 3) float64
        The true poses beside them.
    landmark_table : (k, 5) float64
        Annotated id, true x and y, estimated x and y (metres): every annotated landmark, NaN where not
        mapped, further rows for duplicates; id −1 with NaN truth for estimates that no annotated
        observation supports.
    seconds : float
        Wall clock of the SLAM run; NaN if it failed.
    """

    row: dict[str, object]
    poses: FloatArray
    truth: FloatArray
    landmark_table: FloatArray
    seconds: float


def replay(log: DlrLog, settings: SlamSettings, seed: int = 0) -> Replay:
    """Run SLAM over the whole log and score it against ``truth.txt``.

    Parameters
    ----------
    log : DlrLog
    settings : SlamSettings
    seed : int
        For the row; nothing in a replay is random.

    Returns
    -------
    Replay
        A SLAM run that breaks down is a row whose status says why, not an exception.
    """
    truth = log.truth[1:]
    row = _empty_row(log, settings, seed)
    try:
        result = run_slam(log.steps, settings)
    except VslamError as error:
        failed = row | {"status": f"failed: {error}"}
        return Replay(failed, np.zeros((0, 3)), truth, np.zeros((0, 5)), math.nan)
    seen = true_landmarks(log)
    track = trajectory.evaluate(result.poses, truth, result.covariances)
    marks = landmarks.evaluate(
        result.landmarks, result.matches, seen, log.landmark_positions, unlabelled=True
    )
    row |= vars(track) | vars(marks) | {"status": "ok"}
    return Replay(row, result.poses, truth, _landmark_table(log, result, seen), result.seconds)


def dead_reckoning(log: DlrLog) -> FloatArray:
    """Poses after each step from odometry alone, (n, 3) float64: what the landmarks have to improve on."""
    poses = np.zeros((len(log.steps) + 1, 3))
    for k, (odometry, _) in enumerate(log.steps):
        poses[k + 1] = move(poses[k], odometry.delta)
    return poses[1:]


def true_landmarks(log: DlrLog) -> tuple[IntArray, ...]:
    """Row in ``log.landmark_positions`` of each observation of each step, −1 where it has no annotated id."""
    return tuple(
        np.where(o.ids >= 0, np.searchsorted(log.landmark_ids, o.ids), -1).astype(np.int64)
        for _, o in log.steps
    )


def _landmark_table(log: DlrLog, result: SlamResult, seen: tuple[IntArray, ...]) -> FloatArray:
    table = landmarks.table(result.landmarks, result.matches, seen, log.landmark_positions, unlabelled=True)
    annotated = table[:, 0] >= 0
    table[annotated, 0] = log.landmark_ids[table[annotated, 0].astype(np.int64)]
    return table


def _empty_row(log: DlrLog, settings: SlamSettings, seed: int) -> dict[str, object]:
    """A runs row in which every metric is still empty."""
    return empty_run_row() | {
        "scene": "dlr",
        "illumination": "recorded",
        "filter": "none",
        "backend": settings.backend,
        "association": settings.association,
        "observation": settings.observation,
        "seed": seed,
        "steps": len(log.steps),
        "landmarks_total": len(log.landmark_ids),
    }
