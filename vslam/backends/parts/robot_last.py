"""A mean whose order puts the robot last, [L_1 … L_n, R], for filters that keep a factor in that order."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts.block_update import BlockUpdate
from vslam.backends.parts.full_covariance import state_rows
from vslam.observation import ObservationModel

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_CHUNK = 64


class RobotLast(BlockUpdate):
    """X in that order, and what of a `vslam.slam_backend.Backend` follows from it; parameters as `Ekf`'s."""

    def __init__(self, model: ObservationModel, seed: int = 0) -> None:
        self.model = model
        self._size = 3
        self._X = np.zeros(3)

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: x, y (metres), heading (rad, not wrapped)."""
        return self._X[-3:].copy()

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres."""
        return self._X[:-3].reshape(-1, 2).copy()

    @property
    def covariance(self) -> FloatArray:
        """P in the order of the other filters, robot first, (3 + 2n, 3 + 2n) float64."""
        return self.joint_covariance(np.arange((self._size - 3) // 2))

    @abstractmethod
    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""

    def _landmarks_at(self, numbers: IntArray) -> FloatArray:
        return self._X[:-3].reshape(-1, 2)[numbers]

    def _rows(self, numbers: IntArray) -> IntArray:
        """Rows of the robot, then of the given landmarks, (3 + 2k,)."""
        rows = state_rows(numbers) - 3
        rows[:3] += self._size
        return rows


def grown(square: FloatArray, size: int) -> FloatArray:
    """A Fortran-ordered square with room for ``size`` rows: the same one, or a larger with zeros added."""
    capacity = -(-size // _CHUNK) * _CHUNK
    if capacity <= len(square):
        return square
    larger = np.zeros((capacity, capacity), order="F")
    larger[: len(square), : len(square)] = square
    return larger
