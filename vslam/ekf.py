"""EKF-SLAM, equations 3-14 … 3-37, after Zhang 2014 and Solà's course text.

All matched observations of a step correct the state in one block. Only the lower triangle of P is kept up
to date, so P is symmetric by construction and the correction costs one ``dsyrk``. P lives in a
Fortran-ordered square that grows in chunks, because BLAS through f2py works in place on whole arrays
only; rows beyond the state are zero.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.motion import motion_jacobians, move
from vslam.observation import ObservationModel
from vslam.slam_backend import DISCARDED, NEW, backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Rows by which P grows: 32 landmarks. Copies stay rare and the padding costs dsyrk a few per cent.
_CHUNK = 64


@backends.register("ekf")
class Ekf:
    """The extended Kalman filter over robot and landmarks (eqs. 3-14 … 3-37), a `vslam.slam_backend.Backend`.

    Parameters
    ----------
    model : ObservationModel
        How a landmark is measured.
    """

    name = "ekf"

    def __init__(self, model: ObservationModel) -> None:
        self.model = model
        # X_0 = 0, P_0 = 0 (eq. 3-16); X = [R, L_1 … L_n] (eq. 3-14), P in blocks (eq. 3-15).
        self._size = 3
        self._X = np.zeros(_CHUNK)
        self._P = np.zeros((_CHUNK, _CHUNK), order="F")

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: x, y (metres), heading (rad, not wrapped)."""
        return self._X[:3].copy()

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""
        return _mirror(self._P[:3, :3])

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres."""
        return self._X[3 : self._size].reshape(-1, 2).copy()

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²."""
        variances = self._P.diagonal()[3 : self._size].reshape(-1, 2)
        covariances = self._P.diagonal(-1)[3 : self._size - 1 : 2]
        blocks = np.empty((len(variances), 2, 2))
        blocks[:, 0, 0], blocks[:, 1, 1] = variances.T
        blocks[:, 0, 1] = blocks[:, 1, 0] = covariances
        return blocks

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""
        return self._P[3 : self._size, :3].reshape(-1, 2, 3).transpose(0, 2, 1)

    @property
    def covariance(self) -> FloatArray:
        """P, (3 + 2n, 3 + 2n) float64, a copy."""
        return _mirror(self._P[: self._size, : self._size])

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        rows = _rows(np.asarray(landmarks, dtype=np.int64))
        return self._columns(rows)[rows]

    def predict(self, odometry: Odometry) -> None:
        """Move by one increment; P_MM is untouched.

        Raises
        ------
        VslamError
            When the increment is not finite or its covariance not positive semi-definite.
        """
        _check_odometry(odometry)
        F_R, F_n = motion_jacobians(self._X[:3], odometry.delta)
        P_RR = F_R @ self.pose_covariance @ F_R.T + F_n @ odometry.covariance @ F_n.T  # eq. 3-18
        self._P[:3, :3] = P_RR
        self._P[3 : self._size, :3] = self._P[3 : self._size, :3] @ F_R.T  # P_MR, the transpose of eq. 3-19
        self._X[:3] = move(self._X[:3], odometry.delta)  # eq. 3-17

    def update(self, observations: Observations, hypothesis: IntArray) -> IntArray:
        """Correct with the matched observations, then found landmarks for the new ones.

        Parameters
        ----------
        observations : Observations, n of them
        hypothesis : (n,) int64
            Landmark number, ``NEW`` or ``DISCARDED`` of each observation (eq. 3-30).

        Returns
        -------
        (n,) int64: landmark number of each observation, or ``DISCARDED``.

        Raises
        ------
        VslamError
            When an observation is not finite, its covariance not positive definite, or the hypothesis names
            landmarks that do not exist.
        """
        _check_observations(observations)
        matches = np.array(hypothesis, dtype=np.int64)
        self._check_hypothesis(observations, matches)
        z, S = self.model.measure(observations)
        matched, new = matches >= 0, matches == NEW
        if matched.any():
            self._correct(z[matched], S[matched], matches[matched])
        if new.any():
            matches[new] = self._found(z[new], S[new])
        return matches

    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        landmarks = self._X[3 : self._size].reshape(-1, 2)[numbers]
        Z = self.model.innovation(z, self.model.h(self._X[:3], landmarks)).ravel()  # eq. 3-22
        H = _stack(*self.model.h_jacobians(self._X[:3], landmarks))  # sparse H, eqs. 3-23, 3-24
        rows = _rows(numbers)
        PHt = self._columns(rows) @ H.T
        S_Z = H @ PHt[rows] + _block_diagonal(S)  # eq. 3-25

        # K = P Hᵀ S_Z⁻¹ (eq. 3-26) is never formed: with S_Z = C Cᵀ and W = P Hᵀ C⁻ᵀ it follows that
        # K Z = W C⁻¹ Z and K S_Z Kᵀ = W Wᵀ.
        C, failed = dpotrf(S_Z, lower=1, clean=1)
        if failed:
            raise VslamError("the innovation covariance is not positive definite; the filter has broken down")
        W = dtrsm(1.0, C, np.asfortranarray(PHt), side=1, lower=1, trans_a=1, overwrite_b=1)
        self._X += W @ dtrsm(1.0, C, Z[:, None], lower=1)[:, 0]  # eqs. 3-27, 3-28
        self._P = dsyrk(-1.0, W, beta=1.0, c=self._P, lower=1, overwrite_c=1)  # eq. 3-29

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        """Append landmarks L_{N+1} … (eqs. 3-31 … 3-37) and return their numbers."""
        start, end = self._size, self._size + 2 * len(z)
        self._grow(end)
        pose = self._X[:3]
        G_R, G_z = self.model.g_jacobians(pose, z)
        G = G_R.reshape(-1, 3)
        P_RX = self._columns(np.arange(3))[:start].T
        self._P[start:end, :start] = G @ P_RX  # P_LX = G_R P_RX, eqs. 3-35, 3-36
        P_LL = G @ P_RX[:, :3] @ G.T + _block_diagonal(G_z @ S @ G_z.transpose(0, 2, 1))  # eq. 3-34
        self._P[start:end, start:end] = P_LL  # the new blocks of eq. 3-37
        self._X[start:end] = self.model.g(pose, z).ravel()  # eqs. 3-31 … 3-33
        self._size = end
        return np.arange((start - 3) // 2, (end - 3) // 2)

    def _columns(self, rows: IntArray) -> FloatArray:
        columns = np.empty((len(self._X), len(rows)), order="F")
        _gather(self._P, rows, columns)
        return columns

    def _grow(self, size: int) -> None:
        capacity = -(-size // _CHUNK) * _CHUNK
        if capacity <= len(self._X):
            return
        X, P = np.zeros(capacity), np.zeros((capacity, capacity), order="F")
        X[: self._size] = self._X[: self._size]
        P[: self._size, : self._size] = self._P[: self._size, : self._size]
        self._X, self._P = X, P

    def _check_hypothesis(self, observations: Observations, matches: IntArray) -> None:
        if len(matches) != len(observations):
            raise VslamError(f"{len(matches)} hypotheses for {len(observations)} observations")
        known = (self._size - 3) // 2
        if np.any((matches >= known) | ((matches < 0) & (matches != NEW) & (matches != DISCARDED))):
            raise VslamError(
                f"the hypothesis {matches.tolist()} names landmarks beyond the {known} in the map"
            )


@njit(cache=True)
def _gather(P: FloatArray, rows: IntArray, columns: FloatArray) -> None:
    """Whole columns of the symmetric P from its lower triangle."""
    size = P.shape[0]
    for k in range(len(rows)):
        j = rows[k]
        for i in range(j):
            columns[i, k] = P[j, i]
        for i in range(j, size):
            columns[i, k] = P[i, j]


def _rows(numbers: IntArray) -> IntArray:
    """Rows of the state that hold the robot and the given landmarks."""
    rows = np.empty(3 + 2 * len(numbers), dtype=np.int64)
    rows[:3] = 0, 1, 2
    rows[3::2] = 3 + 2 * numbers
    rows[4::2] = 4 + 2 * numbers
    return rows


def _stack(H_R: FloatArray, H_L: FloatArray) -> FloatArray:
    """H without its zero columns: [H_R | diag(H_L)], (2k, 3 + 2k)."""
    return np.hstack([H_R.reshape(-1, 3), _block_diagonal(H_L)])


def _block_diagonal(blocks: FloatArray) -> FloatArray:
    """(k, 2, 2) blocks on the diagonal of a (2k, 2k) matrix."""
    k = len(blocks)
    matrix = np.zeros((k, 2, k, 2))
    each = np.arange(k)
    matrix[each, :, each, :] = blocks
    return matrix.reshape(2 * k, 2 * k)


@njit(cache=True)
def _mirror(matrix: FloatArray) -> FloatArray:
    """Copy a symmetric matrix from its lower triangle."""
    n = matrix.shape[0]
    out = np.empty((n, n))
    for j in range(n):
        for i in range(j, n):
            out[i, j] = out[j, i] = matrix[i, j]
    return out


def _symmetric(covariances: FloatArray) -> bool:
    """Whether matrices (…, k, k) equal their transposes to a part in a million of their largest entry."""
    skew = np.abs(covariances - covariances.swapaxes(-1, -2))
    return bool(skew.max(initial=0.0) <= 1e-6 * np.abs(covariances).max(initial=0.0))


def _check_odometry(odometry: Odometry) -> None:
    Q = odometry.covariance
    if not (np.isfinite(odometry.delta).all() and np.isfinite(Q).all()):
        raise VslamError("the odometry holds a value that is not finite")
    # Semi-definite is enough: a robot that cannot slide has no noise sideways.
    if not _symmetric(Q) or np.linalg.eigvalsh(Q)[0] < -1e-9 * np.trace(Q):
        raise VslamError(f"the odometry covariance {Q.tolist()} is not positive semi-definite")


def _check_observations(observations: Observations) -> None:
    S = observations.covariances
    if not (np.isfinite(observations.points).all() and np.isfinite(S).all()):
        raise VslamError("an observation holds a value that is not finite")
    definite = (S[:, 0, 0] > 0.0) & (S[:, 0, 0] * S[:, 1, 1] > S[:, 0, 1] ** 2)
    if not definite.all() or not _symmetric(S):
        worst = int(np.argmin(definite))
        raise VslamError(
            f"the covariance {S[worst].tolist()} of observation {worst} is not positive definite"
        )
