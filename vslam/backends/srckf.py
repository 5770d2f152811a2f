"""Square-root cubature Kalman filter SLAM, the second of the two that Li et al. 2017 compare.

Source: Arasaratnam & Haykin 2009, "Cubature Kalman filters", section VI and appendix B. P itself never
appears: the filter carries a lower-triangular L with P = L Lᵀ, so P is symmetric positive semi-definite by
construction.

The robot comes *last* in the factor's order, [L_1 … L_n, R]. Its three rows are then the only ones that a
motion changes, and a new landmark changes the last rows alone; both cost O(n). The correction is the array
algorithm (Kailath, Sayed & Hassibi 2000, section 12.1; appendix B there)

    [ S_v^½  H L ]       [ S_Z^½  0  ]
    [ 0      L   ] Θ  =  [ K̄      L⁺ ],     Θ orthogonal,

taken block of columns by block of columns from the last to the first, which keeps L⁺ triangular.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.linalg.blas import dgemm

from vslam.backends.parts import sigma_moves
from vslam.backends.parts.full_covariance import block_diagonal
from vslam.backends.parts.robot_last import RobotLast, grown
from vslam.backends.parts.sigma_points import cubature, factors, lower_triangle
from vslam.errors import VslamError
from vslam.frame import Odometry
from vslam.observation import ObservationModel
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@backends.register("srckf")
class SquareRootCkf(RobotLast):
    """The square-root cubature Kalman filter, a `vslam.slam_backend.Backend`; parameters as `Ekf`'s."""

    name = "srckf"

    def __init__(self, model: ObservationModel, seed: int = 0) -> None:
        super().__init__(model, seed)
        self._L = grown(np.zeros((self._size, self._size)), self._size)

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""
        rows = self._robot_rows
        return rows @ rows.T

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²."""
        rows = self._L[: self._size - 3, : self._size].reshape(-1, 2, self._size)
        return np.asarray(rows @ rows.transpose(0, 2, 1))

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""
        P_MR = self._L[: self._size - 3, : self._size] @ self._robot_rows.T
        return P_MR.reshape(-1, 2, 3).transpose(0, 2, 1)

    @property
    def memory_bytes(self) -> int:
        """Bytes of X and L."""
        return self._X.nbytes + self._L.nbytes

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        rows = self._L[self._rows(np.asarray(landmarks, dtype=np.int64)), : self._size]
        return np.asarray(rows @ rows.T)

    def _predict(self, odometry: Odometry) -> None:
        """Only the robot's rows of L change."""
        fit = sigma_moves.motion(self.pose, lower_triangle(self._robot_rows), odometry, cubature)
        start, end = self._size - 3, self._size
        self._L[start:end, :start] = fit.matrix @ self._L[start:end, :start]
        own = fit.matrix @ self._L[start:end, start:end]
        self._L[start:end, start:end] = lower_triangle(np.hstack([own, fit.residual]))
        self._X[start:] = fit.mean

    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        rows = self._rows(numbers)
        L_s = self._L[rows, : self._size]
        expected, fit = sigma_moves.measurement(self.model, self._X[rows], lower_triangle(L_s), cubature)
        Z = self.model.innovation(z, expected + fit.mean.reshape(-1, 2)).ravel()
        root = lower_triangle(np.hstack([fit.residual, block_diagonal(factors(S))]))
        root, K = triangularise(root, fit.matrix @ L_s, self._L[: self._size, : self._size])
        if not np.isfinite(root).all() or not root.diagonal().all():
            raise VslamError("the innovation covariance is not positive definite; the filter has broken down")
        self._X += K @ solve_triangular(root, Z, lower=True)

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        A = lower_triangle(self._robot_rows)
        fit = sigma_moves.founding(self.model, self.pose, A, z, S, cubature)
        start, added = self._size - 3, 2 * len(z)
        robot = self._robot_rows
        pose = self.pose
        self._L = grown(self._L, self._size + added)
        last = self._size + added
        both = np.vstack([fit.matrix @ robot, robot])
        noise = np.vstack([fit.residual, np.zeros((3, fit.residual.shape[1]))])
        self._L[start:last, :start] = both[:, :start]
        self._L[start:last, start:last] = lower_triangle(np.hstack([both[:, start:], noise]))
        self._X = np.concatenate([self._X[:start], fit.mean, pose])
        self._size = last
        return np.arange(start // 2, (start + added) // 2)

    @property
    def _robot_rows(self) -> FloatArray:
        return self._L[self._size - 3 : self._size, : self._size].copy()


def triangularise(root: FloatArray, HL: FloatArray, L: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The array algorithm: L becomes L⁺ in place; returns S_Z^½ (m, m), lower-triangular, and K̄ (n, m).

    Parameters
    ----------
    root : (m, m) float64
        S_v^½, lower-triangular.
    HL : (m, n) float64
    L : (n, n) float64
        Lower-triangular.
    """
    m, n = HL.shape
    K = np.zeros((n, m), order="F")
    width = max(32, m)
    for end in range(n, 0, -width):
        start = max(0, end - width)
        b = end - start
        array = np.zeros((m + b, m + b))
        array[:m, :m], array[:m, m:], array[m:, m:] = root, HL[:, start:end], L[start:end, start:end]
        Q, R = np.linalg.qr(array.T)
        Q *= np.where(R.diagonal() < 0.0, -1.0, 1.0)
        done = array @ Q
        root = np.tril(done[:m, :m])
        below = np.empty((n - end, m + b), order="F")
        below[:, :m], below[:, m:] = K[end:], L[end:, start:end]
        below = dgemm(1.0, below, Q)
        K[start:end], K[end:] = done[m:, :m], below[:, :m]
        L[start:end, start:end], L[end:, start:end] = np.tril(done[m:, m:]), below[:, m:]
    return root, K
