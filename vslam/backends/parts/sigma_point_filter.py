"""A filter with whole covariance whose motion, measurement and founding go through sigma points."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts import sigma_moves
from vslam.backends.parts.full_covariance import FullCovariance, block_diagonal, state_rows
from vslam.backends.parts.sigma_points import Rule, factor
from vslam.frame import Odometry

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class SigmaPointFilter(FullCovariance):
    """UKF or CKF, by the rule that a subclass names."""

    @staticmethod
    @abstractmethod
    def rule_of(n: int) -> Rule:
        """The sigma points of n dimensions."""

    def _predict(self, odometry: Odometry) -> None:
        A = factor(self.pose_covariance)
        fit = sigma_moves.motion(self._X[:3], A, odometry, self.rule_of)
        self._move(fit.mean, fit.matrix, fit.residual @ fit.residual.T)

    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        A = factor(self.joint_covariance(numbers))
        state = self._X[state_rows(numbers)]
        expected, fit = sigma_moves.measurement(self.model, state, A, self.rule_of)
        Z = self.model.innovation(z, expected + fit.mean.reshape(-1, 2)).ravel()
        self._apply(numbers, fit.matrix, fit.residual @ fit.residual.T + block_diagonal(S), Z)

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        A = factor(self.pose_covariance)
        fit = sigma_moves.founding(self.model, self._X[:3], A, z, S, self.rule_of)
        return self._append(fit.mean.reshape(-1, 2), fit.matrix, fit.residual @ fit.residual.T)
