"""A drive among known landmarks: what a back-end is given, and what is true about it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError
from bench.sequences import landmark_log
from bench.sequences.dlr import DlrLog
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Drive:
    """One stream of odometry and observations, in the frame of the first pose.

    Attributes
    ----------
    name : str
        Scene of the rows.
    steps : tuple of n (Odometry, Observations)
        Each increment with what is seen after it.
    truth : (n, 3) float64
        True pose after each step: x, y (metres), heading (rad, not wrapped).
    landmark_ids : (m,) int64
        Rising.
    landmark_positions : (m, 2) float64
        True positions, metres.
    """

    name: str
    steps: tuple[tuple[Odometry, Observations], ...]
    truth: FloatArray
    landmark_ids: IntArray
    landmark_positions: FloatArray

    @property
    def seen(self) -> tuple[IntArray, ...]:
        """Row in ``landmark_positions`` of each observation of each step, −1 where it has no known id."""
        return tuple(
            np.where(o.ids >= 0, np.searchsorted(self.landmark_ids, o.ids), -1).astype(np.int64)
            for _, o in self.steps
        )


def from_start(poses: FloatArray) -> FloatArray:
    """Poses (n, 3) as the robot counts them: from its first one, headings not wrapped."""
    return np.column_stack([to_local(poses[0], poses[:, :2]), poses[:, 2] - poses[0, 2]])


def recorded(log: DlrLog, name: str = "dlr") -> Drive:
    """The DLR log as it was recorded."""
    return Drive(name, log.steps, log.truth[1:], log.landmark_ids, log.landmark_positions)


@lru_cache(maxsize=2)
def from_file(path: Path, name: str) -> Drive:
    """A landmark log as its file has it; read, and solved where it has no reference, once per process.

    Raises
    ------
    BenchError
        As `landmark_log.load`, and where the log has neither a reference nor a smoothed solution.
    """
    log = landmark_log.load(path)
    truth, positions = log.reference, log.landmark_positions
    if truth is None or not np.isfinite(positions).all():
        truth, positions = _smoothed(log, path)
    return Drive(name, log.steps, truth, log.landmark_ids, positions)


def _smoothed(log: landmark_log.LandmarkLog, path: Path) -> tuple[FloatArray, FloatArray]:
    """Poses and landmarks of the least-squares solution, landmarks by rising id."""
    from vslam.errors import VslamError
    from vslam.slam import SlamSettings, run_slam

    try:
        result = run_slam(log.steps, SlamSettings("graph", "annotated", "cartesian"))
    except VslamError as error:
        raise BenchError(
            f"{path}: has no vertices for a reference, and cannot be smoothed: {error}"
        ) from None
    assert result.smoothed is not None
    numbers = np.full(len(log.landmark_ids), -1)
    for (_, seen), matches in zip(log.steps, result.matches, strict=True):
        numbers[np.searchsorted(log.landmark_ids, seen.ids)] = matches
    return result.smoothed.poses, result.smoothed.landmarks[numbers]
