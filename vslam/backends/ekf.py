"""EKF-SLAM, equations 3-14 … 3-37, after Zhang 2014 and Solà's course text.

All matched observations of a step correct the state in one block. `Ekf` names the three places where it
linearises, so that filters which differ in the point of linearisation alone are this filter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts.full_covariance import FullCovariance, block_diagonal, stacked_jacobian
from vslam.frame import Odometry
from vslam.motion import motion_jacobians, move
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@backends.register("ekf")
class Ekf(FullCovariance):
    """The extended Kalman filter over robot and landmarks, a `vslam.slam_backend.Backend`."""

    name = "ekf"

    def _predict(self, odometry: Odometry) -> None:
        """Eqs. 3-17 … 3-20; P_MM is untouched."""
        moved = move(self._X[:3], odometry.delta)  # eq. 3-17
        F_R, F_n = self._motion_jacobians(odometry.delta, moved)
        self._move(moved, F_R, F_n @ odometry.covariance @ F_n.T)  # eqs. 3-18 … 3-20

    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        expected = self.model.h(self._X[:3], self._landmarks_at(numbers))
        Z = self.model.innovation(z, expected).ravel()  # eq. 3-22
        H = stacked_jacobian(*self._measurement_jacobians(numbers))  # sparse H, eqs. 3-23, 3-24
        self._apply(numbers, H, block_diagonal(S), Z)

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        """Append landmarks L_{N+1} … (eqs. 3-31 … 3-37) and return their numbers."""
        landmarks = self.model.g(self._X[:3], z)  # eqs. 3-31 … 3-33
        G_R, G_z = self._founding_jacobians(z, landmarks)
        return self._append(landmarks, G_R.reshape(-1, 3), block_diagonal(G_z @ S @ G_z.transpose(0, 2, 1)))

    def _motion_jacobians(self, delta: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F_R and F_n of a motion from the present pose to ``moved`` (eqs. 3-10, 3-11)."""
        return motion_jacobians(self._X[:3], delta)

    def _measurement_jacobians(self, numbers: IntArray) -> tuple[FloatArray, FloatArray]:
        """H_R (k, 2, 3) and H_L (k, 2, 2) of some landmarks."""
        return self.model.h_jacobians(self._X[:3], self._landmarks_at(numbers))

    def _founding_jacobians(self, z: FloatArray, landmarks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """G_R (k, 2, 3) and G_z (k, 2, 2) of new landmarks."""
        return self.model.g_jacobians(self._X[:3], z)
