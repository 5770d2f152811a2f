"""Exact extended information filter SLAM.

Source: Thrun, Burgard & Fox 2005, *Probabilistic Robotics*, sections 3.5 and 12.2–12.3 without sparsification
(the exact filter that SEIF approximates); Thrun et al. 2004, "Simultaneous localization and mapping with
sparse extended information filters", eqs. 13 … 27.

The filter carries Ω = P⁻¹. A measurement adds Hᵀ S⁻¹ H to the blocks of robot and landmark alone and a new
landmark is one more measurement, with nothing known about it before; the price is the motion, which links
everything the robot was linked to. Means are needed to linearise, so they are kept beside Ω and corrected by
Ω δ = Hᵀ S⁻¹ Z, which takes one Cholesky factor of Ω per step. Linearised where the EKF is, it is the EKF.

The robot comes last, [L_1 … L_n, R], so that the factor's last block is that of P_RR.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve
from scipy.linalg.blas import dsyrk
from scipy.linalg.lapack import dpotrf, dpotri

from vslam.backends.parts.full_covariance import block_diagonal, stacked_jacobian
from vslam.backends.parts.robot_last import RobotLast, grown
from vslam.errors import VslamError
from vslam.frame import Odometry
from vslam.motion import motion_jacobians, move
from vslam.observation import ObservationModel
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# P_0 = 0 has no inverse; a micrometre and a microradian stand for it.
_START = 1e12


@backends.register("information")
class InformationFilter(RobotLast):
    """The extended information filter, a `vslam.slam_backend.Backend`; parameters as `Ekf`'s."""

    name = "information"

    def __init__(self, model: ObservationModel, seed: int = 0) -> None:
        super().__init__(model, seed)
        self._Omega = grown(_START * np.eye(3), self._size)  # lower triangle
        self._factor: FloatArray | None = None

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""
        inverse = np.linalg.inv(self._cholesky()[-3:, -3:])
        return np.asarray(inverse.T @ inverse)

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²; inverts Ω."""
        P, n = self._inverse(), (self._size - 3) // 2
        return np.asarray(P[:-3, :-3].reshape(n, 2, n, 2)[np.arange(n), :, np.arange(n), :])

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""
        unit = np.zeros((self._size, 3))
        unit[-3:] = np.eye(3)
        columns = cho_solve((self._cholesky(), True), unit)
        return np.asarray(columns[:-3].reshape(-1, 2, 3).transpose(0, 2, 1))

    @property
    def memory_bytes(self) -> int:
        """Bytes of the mean, Ω and its factor."""
        return self._X.nbytes + self._Omega.nbytes + self._cholesky().nbytes

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        rows = self._rows(np.asarray(landmarks, dtype=np.int64))
        unit = np.zeros((self._size, len(rows)))
        unit[rows, np.arange(len(rows))] = 1.0
        P = cho_solve((self._cholesky(), True), unit)[rows]
        return np.asarray(0.5 * (P + P.T))

    def _predict(self, odometry: Odometry) -> None:
        """With A = F⁻ᵀ Ω F⁻¹ by blocks and N the noise, (A⁻¹ + N)⁻¹ by Woodbury."""
        F_R, F_n = motion_jacobians(self._X[-3:], odometry.delta)
        N, back = F_n @ odometry.covariance @ F_n.T, np.linalg.inv(F_R)
        R, M = slice(self._size - 3, self._size), slice(0, self._size - 3)
        own = np.tril(self._Omega[R, R])
        A_RR = back.T @ (own + np.tril(own, -1).T) @ back
        A_RM = back.T @ self._Omega[R, M]
        # (I + N A)⁻¹ N needs no inverse of N, which is singular for a robot that cannot slide.
        gain = np.linalg.solve(np.eye(3) + N @ A_RR, N)
        scales, axes = np.linalg.eigh(0.5 * (gain + gain.T))
        root = axes * np.sqrt(np.maximum(scales, 0.0))
        links = np.zeros((len(self._Omega), 3), order="F")
        links[M] = A_RM.T @ root
        self._Omega = dsyrk(-1.0, links, beta=1.0, c=self._Omega, lower=1, overwrite_c=1)
        shrink = np.linalg.inv(np.eye(3) + A_RR @ N)
        self._Omega[R, M] = shrink @ A_RM
        self._Omega[R, R] = shrink @ A_RR
        self._X[-3:] = move(self._X[-3:], odometry.delta)
        self._factor = None

    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        Z = self.model.innovation(z, self.model.h(self._X[-3:], self._landmarks_at(numbers)))
        HtS = self._add(S, numbers)
        step = np.zeros(self._size)
        step[self._rows(numbers)] = HtS @ Z.ravel()
        self._X += cho_solve((self._cholesky(), True), step)

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        start, added = self._size - 3, 2 * len(z)
        Omega = self._Omega = grown(self._Omega, self._size + added)
        robot = Omega[start : start + 3, : start + 3].copy()
        Omega[start : start + 3] = 0.0
        Omega[start + added : start + added + 3, :start] = robot[:, :start]
        Omega[start + added : start + added + 3, start + added : start + added + 3] = robot[:, start:]
        landmarks = self.model.g(self._X[-3:], z)
        self._X = np.concatenate([self._X[:start], landmarks.ravel(), self._X[start:]])
        self._size += added
        numbers = np.arange(start // 2, (start + added) // 2)
        self._add(S, numbers)
        return numbers

    def _add(self, S: FloatArray, numbers: IntArray) -> FloatArray:
        """Ω ← Ω + Hᵀ S⁻¹ H on the rows of robot and landmarks; returns their Hᵀ S⁻¹."""
        H = stacked_jacobian(*self.model.h_jacobians(self._X[-3:], self._landmarks_at(numbers)))
        HtS = H.T @ block_diagonal(np.asarray(np.linalg.inv(S), dtype=np.float64))
        rows = self._rows(numbers)
        information = HtS @ H
        i, j = np.nonzero(rows[:, None] >= rows[None, :])
        self._Omega[rows[i], rows[j]] += information[i, j]
        self._factor = None
        return np.asarray(HtS)

    def _cholesky(self) -> FloatArray:
        """Lower-triangular factor of Ω, kept until Ω changes."""
        if self._factor is None:
            self._factor, failed = dpotrf(self._Omega[: self._size, : self._size], lower=1, clean=1)
            if failed:
                raise VslamError(
                    "the information matrix is not positive definite; the filter has broken down"
                )
        assert self._factor is not None
        return self._factor

    def _inverse(self) -> FloatArray:
        P, _ = dpotri(self._cholesky(), lower=1)
        return np.tril(P) + np.tril(P, -1).T
