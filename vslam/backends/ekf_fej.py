"""EKF-SLAM with first-estimate Jacobians.

Source: Huang, Mourikis & Roumeliotis 2010, "Observability-based rules for designing consistent EKF SLAM
estimators", section 5.1 (FEJ-EKF), from their 2008 ISRR paper "Analysis and improvement of the consistency of
extended Kalman filter based SLAM".

A textbook EKF evaluates its Jacobians at changing estimates of the same quantity. The linearised system is
then observable in the heading of the whole map, which the true system is not, and the filter gains
information that nobody measured. Here each quantity is linearised at its first estimate alone: a pose where
it was predicted, a landmark where it was founded (their eqs. 38, 39); state and innovation use the latest
estimates as ever.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.backends.ekf import Ekf
from vslam.motion import motion_jacobians
from vslam.observation import ObservationModel
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@backends.register("ekf_fej")
class EkfFej(Ekf):
    """The extended Kalman filter with first-estimate Jacobians."""

    name = "ekf_fej"

    def __init__(self, model: ObservationModel, seed: int = 0) -> None:
        super().__init__(model, seed)
        self._first_pose = np.zeros(3)
        self._first_landmarks = np.zeros((0, 2))

    def _motion_jacobians(self, delta: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F_R between predicted poses: p_{k+1|k} − p_{k|k−1} in place of p_{k+1|k} − p_{k|k}."""
        _, F_n = motion_jacobians(self._X[:3], delta)
        F_R = np.eye(3)
        way = moved - self._first_pose
        F_R[0, 2], F_R[1, 2] = -way[1], way[0]
        self._first_pose = moved
        return F_R, F_n

    def _measurement_jacobians(self, numbers: IntArray) -> tuple[FloatArray, FloatArray]:
        return self.model.h_jacobians(self._first_pose, self._first_landmarks[numbers])

    def _founding_jacobians(self, z: FloatArray, landmarks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """G out of the H of later sights: H_R + H_L G_R = 0, so founding, too, measures no heading."""
        self._first_landmarks = np.vstack([self._first_landmarks, landmarks])
        H_R, H_L = self.model.h_jacobians(self._first_pose, landmarks)
        G_z = np.asarray(np.linalg.inv(H_L), dtype=np.float64)
        return np.asarray(-G_z @ H_R), G_z
