"""State X and covariance P of robot and landmarks (eqs. 3-14 … 3-16), for every filter that keeps both whole.

Only the lower triangle of P is kept up to date, so P is symmetric by construction. P lives in a
Fortran-ordered square that grows in chunks, because BLAS through f2py works in place on whole arrays only;
rows beyond the state are zero.

A correction subtracts W Wᵀ with W of few columns (eq. 3-29). That costs as many bytes as P has, whatever the
number of columns, so columns are collected first and subtracted together, P_now = P − W Wᵀ, when there are
`_PENDING` of them (delayed updates, Guivant & Nebot 2001, by columns instead of regions). Nothing is
approximated: everything that reads P takes W into account.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from vslam.backends.parts.block_update import BlockUpdate
from vslam.errors import VslamError
from vslam.observation import ObservationModel

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Rows by which P grows: 32 landmarks. Copies stay rare and the padding costs dsyrk a few per cent.
_CHUNK = 64
# Columns of W: where dsyrk is bound by arithmetic and no more by memory, on the machines tried.
_PENDING = 48


class FullCovariance(BlockUpdate):
    """X and P with everything of a `vslam.slam_backend.Backend` but prediction, correction and founding.

    Parameters
    ----------
    model : ObservationModel
        How a landmark is measured.
    seed : int
        Unused: nothing here is random.
    """

    def __init__(self, model: ObservationModel, seed: int = 0) -> None:
        self.model = model
        # X_0 = 0, P_0 = 0 (eq. 3-16); X = [R, L_1 … L_n] (eq. 3-14), P in blocks (eq. 3-15).
        self._size = 3
        self._X = np.zeros(_CHUNK)
        self._P = np.zeros((_CHUNK, _CHUNK), order="F")
        self._W = np.zeros((_CHUNK, _PENDING), order="F")
        self._pending = 0

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: x, y (metres), heading (rad, not wrapped)."""
        return self._X[:3].copy()

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""
        W_R = self._W[:3, : self._pending]
        P_RR = _mirror(self._P[:3, :3]) - W_R @ W_R.T
        return 0.5 * (P_RR + P_RR.T)

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres."""
        return self._X[3 : self._size].reshape(-1, 2).copy()

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²."""
        self._settle()
        variances = self._P.diagonal()[3 : self._size].reshape(-1, 2)
        covariances = self._P.diagonal(-1)[3 : self._size - 1 : 2]
        blocks = np.empty((len(variances), 2, 2))
        blocks[:, 0, 0], blocks[:, 1, 1] = variances.T
        blocks[:, 0, 1] = blocks[:, 1, 0] = covariances
        return blocks

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""
        self._settle()
        return self._P[3 : self._size, :3].reshape(-1, 2, 3).transpose(0, 2, 1)

    @property
    def covariance(self) -> FloatArray:
        """P, (3 + 2n, 3 + 2n) float64, a copy."""
        self._settle()
        return _mirror(self._P[: self._size, : self._size])

    @property
    def memory_bytes(self) -> int:
        """Bytes of X, P and W."""
        return self._X.nbytes + self._P.nbytes + self._W.nbytes

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        rows = state_rows(np.asarray(landmarks, dtype=np.int64))
        return self._columns(rows)[rows]

    def _landmarks_at(self, numbers: IntArray) -> FloatArray:
        """Estimates of some landmarks, (k, 2)."""
        return self._X[3 : self._size].reshape(-1, 2)[numbers]

    def _move(self, pose: FloatArray, F_R: FloatArray, noise: FloatArray) -> None:
        """Set the pose, and P_RR ← F_R P_RR F_Rᵀ + noise, P_MR ← P_MR F_Rᵀ (eqs. 3-18, 3-19)."""
        self._P[:3, :3] = F_R @ _mirror(self._P[:3, :3]) @ F_R.T + noise
        self._P[3 : self._size, :3] = self._P[3 : self._size, :3] @ F_R.T
        self._W[:3, : self._pending] = F_R @ self._W[:3, : self._pending]
        self._X[:3] = pose

    def _gain(self, PHt: FloatArray, S_Z: FloatArray, Z: FloatArray) -> FloatArray:
        """P ← P − K S_Z Kᵀ (eq. 3-29); returns K Z (eq. 3-27) for all rows of the state.

        K = P Hᵀ S_Z⁻¹ (eq. 3-26) is never formed: with S_Z = C Cᵀ and W = P Hᵀ C⁻ᵀ it follows that
        K Z = W C⁻¹ Z and K S_Z Kᵀ = W Wᵀ.
        """
        C, failed = dpotrf(S_Z, lower=1, clean=1)
        if failed:
            raise VslamError("the innovation covariance is not positive definite; the filter has broken down")
        W = dtrsm(1.0, C, np.asfortranarray(PHt), side=1, lower=1, trans_a=1, overwrite_b=1)
        self._subtract(W)
        return np.asarray(W @ dtrsm(1.0, C, Z[:, None], lower=1)[:, 0])

    def _subtract(self, W: FloatArray) -> None:
        if self._pending + W.shape[1] > _PENDING:
            self._settle()
        if W.shape[1] > _PENDING:
            self._P = dsyrk(-1.0, W, beta=1.0, c=self._P, lower=1, overwrite_c=1)
            return
        self._W[:, self._pending : self._pending + W.shape[1]] = W
        self._pending += W.shape[1]

    def _settle(self) -> None:
        """Subtract the collected columns from P."""
        if self._pending:
            W = self._W[:, : self._pending]
            self._P = dsyrk(-1.0, W, beta=1.0, c=self._P, lower=1, overwrite_c=1)
            self._pending = 0

    def _append(self, landmarks: FloatArray, G: FloatArray, noise: FloatArray) -> IntArray:
        """Append k landmarks: P_LX = G P_RX and P_LL = G P_RR Gᵀ + noise (eqs. 3-34 … 3-37).

        ``G`` is (2k, 3), ``noise`` (2k, 2k). Returns their numbers.
        """
        start, end = self._size, self._size + 2 * len(landmarks)
        self._grow(end)
        P_XR = self._P[:start, :3].copy()
        P_XR[:3] = _mirror(P_XR[:3])
        self._P[start:end, :start] = G @ P_XR.T
        self._P[start:end, start:end] = G @ P_XR[:3] @ G.T + noise
        self._W[start:end, : self._pending] = G @ self._W[:3, : self._pending]
        self._X[start:end] = landmarks.ravel()
        self._size = end
        return np.arange((start - 3) // 2, (end - 3) // 2)

    def _columns(self, rows: IntArray) -> FloatArray:
        """Whole columns of the symmetric P, pending ones subtracted, (capacity, k)."""
        columns = np.empty((len(self._X), len(rows)), order="F")
        _gather(self._P, rows, columns)
        if self._pending:
            W = self._W[:, : self._pending]
            columns = dgemm(-1.0, W, W[rows], beta=1.0, c=columns, trans_b=1, overwrite_c=1)
        return columns

    def _grow(self, size: int) -> None:
        capacity = -(-size // _CHUNK) * _CHUNK
        if capacity <= len(self._X):
            return
        n = len(self._X)
        X, P = np.zeros(capacity), np.zeros((capacity, capacity), order="F")
        W = np.zeros((capacity, _PENDING), order="F")
        X[:n], P[:n, :n], W[:n] = self._X, self._P, self._W
        self._X, self._P, self._W = X, P, W


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


def state_rows(numbers: IntArray) -> IntArray:
    """Rows of the state that hold the robot and the given landmarks, (3 + 2k,)."""
    rows = np.empty(3 + 2 * len(numbers), dtype=np.int64)
    rows[:3] = 0, 1, 2
    rows[3::2] = 3 + 2 * numbers
    rows[4::2] = 4 + 2 * numbers
    return rows


def block_diagonal(blocks: FloatArray) -> FloatArray:
    """(k, 2, 2) blocks on the diagonal of a (2k, 2k) matrix."""
    k = len(blocks)
    matrix = np.zeros((k, 2, k, 2))
    each = np.arange(k)
    matrix[each, :, each, :] = blocks
    return matrix.reshape(2 * k, 2 * k)


def stacked_jacobian(H_R: FloatArray, H_L: FloatArray) -> FloatArray:
    """H without its zero columns: [H_R | diag(H_L)], (2k, 3 + 2k)."""
    return np.hstack([H_R.reshape(-1, 3), block_diagonal(H_L)])


@njit(cache=True)
def _mirror(matrix: FloatArray) -> FloatArray:
    """Copy a symmetric matrix from its lower triangle."""
    n = matrix.shape[0]
    out = np.empty((n, n))
    for j in range(n):
        for i in range(j, n):
            out[i, j] = out[j, i] = matrix[i, j]
    return out
