"""SLAM over the recorded DLR log, scored: once per back-end, association and observation form."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bench.score import Replay, run_and_score
from bench.sequences.dlr import DlrLog
from bench.sequences.drive import recorded
from vslam.motion import move
from vslam.slam import SlamSettings

__all__ = ["Replay", "dead_reckoning", "replay", "replays", "true_landmarks"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def replay(log: DlrLog, settings: SlamSettings, seed: int = 0) -> Replay:
    """Run SLAM over the whole log and score its online estimate against ``truth.txt``.

    Parameters
    ----------
    log : DlrLog
    settings : SlamSettings
    seed : int
        For the row.

    Returns
    -------
    Replay
        A SLAM run that breaks down is a row whose status says why, not an exception.
    """
    return replays(log, settings, settings.backend, seed)[0]


def replays(
    log: DlrLog, settings: SlamSettings, label: str, seed: int = 0, bound_m: float = math.nan
) -> tuple[Replay, ...]:
    """All estimates of a run over the whole log; see `bench.score.run_and_score`."""
    return run_and_score(recorded(log), settings, label, seed, bound_m)


def dead_reckoning(log: DlrLog) -> FloatArray:
    """Poses after each step from odometry alone, (n, 3) float64: what the landmarks have to improve on."""
    poses = np.zeros((len(log.steps) + 1, 3))
    for k, (odometry, _) in enumerate(log.steps):
        poses[k + 1] = move(poses[k], odometry.delta)
    return poses[1:]


def true_landmarks(log: DlrLog) -> tuple[IntArray, ...]:
    """Row in ``log.landmark_positions`` of each observation of each step, −1 where it has no annotated id."""
    return recorded(log).seen
