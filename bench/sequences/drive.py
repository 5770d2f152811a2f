"""A drive among known landmarks: what a back-end is given, and what is true about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.sequences.dlr import DlrLog
from vslam.frame import Observations, Odometry

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


def recorded(log: DlrLog, name: str = "dlr") -> Drive:
    """The DLR log as it was recorded."""
    return Drive(name, log.steps, log.truth[1:], log.landmark_ids, log.landmark_positions)
