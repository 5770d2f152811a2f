"""State X and covariance P of robot and landmarks (eqs. 3-14 … 3-16), for every filter that keeps both whole.

What a picture does, it does to an active area of landmarks around the robot alone (`active_area.py`); the
rest of X and P follows when the robot leaves the area or when it is asked for.

Only the lower triangle of P is kept up to date, so P is symmetric by construction. P lives in a
Fortran-ordered square that grows in chunks, because BLAS through f2py works in place on whole arrays only;
rows beyond the state are zero.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk

from vslam.backends.parts.active_area import ActiveArea
from vslam.backends.parts.block_update import BlockUpdate
from vslam.errors import VslamError
from vslam.observation import ObservationModel

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Rows by which P grows: 32 landmarks. Copies stay rare and the padding costs dsyrk a few per cent.
_CHUNK = 64
# Rows that an area may grow by before the robot enters it anew.
_ROOM = 64


class FullCovariance(BlockUpdate):
    """X and P with everything of a `vslam.slam_backend.Backend` but prediction, correction and founding.

    Parameters
    ----------
    model : ObservationModel
        How a landmark is measured.
    seed : int
        Unused: nothing here is random.
    """

    nearest = 24
    """Landmarks nearest to the robot that an active area takes in, beside those just seen (16 … 32 take the
    same time on the DLR log)."""

    def __init__(self, model: ObservationModel, seed: int = 0) -> None:
        self.model = model
        # X_0 = 0, P_0 = 0 (eq. 3-16); X = [R, L_1 … L_n] (eq. 3-14), P in blocks (eq. 3-15).
        self._size = 3
        self._X = np.zeros(_CHUNK)
        self._P = np.zeros((_CHUNK, _CHUNK), order="F")
        self._place = np.full(_CHUNK, -1, dtype=np.int64)  # of each landmark in the area, −1 outside
        self._area = ActiveArea(np.arange(3), np.zeros((3, 3)), _ROOM)
        self._blocks = np.zeros((0, 2, 2))  # of the landmarks outside, after what the area has told

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: x, y (metres), heading (rad, not wrapped)."""
        return self._X[:3].copy()

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""
        return self._area.P_AA[:3, :3].copy()

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres."""
        self._settle_means()
        return self._X[3 : self._size].reshape(-1, 2).copy()

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²."""
        if self._area.told == 0:
            self._blocks = self._settled_blocks()
        _take_from_blocks(self._blocks, self._area.untold_loss_of_others())
        blocks = np.zeros(((self._size - 3) // 2, 2, 2))
        blocks[: len(self._blocks)] = self._blocks
        _put_blocks(blocks, self._area.rows, self._area.P_AA)
        return blocks

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""
        return self._area.columns(3)[3:].reshape(-1, 2, 3).transpose(0, 2, 1)

    @property
    def covariance(self) -> FloatArray:
        """P, (3 + 2n, 3 + 2n) float64, a copy."""
        self._settle()
        return _mirror(self._P[: self._size, : self._size])

    @property
    def memory_bytes(self) -> int:
        """Bytes of X, P and the active area."""
        return self._X.nbytes + self._P.nbytes + self._area.memory_bytes

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        at = self._at(np.asarray(landmarks, dtype=np.int64))
        return self._area.P_AA[at[:, None], at]

    def _landmarks_at(self, numbers: IntArray) -> FloatArray:
        """Estimates of some landmarks, (k, 2)."""
        self._at(numbers)
        return self._X[3 : self._size].reshape(-1, 2)[numbers]

    def _move(self, pose: FloatArray, F_R: FloatArray, noise: FloatArray) -> None:
        """Set the pose, and P_RR ← F_R P_RR F_Rᵀ + noise, P_MR ← P_MR F_Rᵀ (eqs. 3-18, 3-19)."""
        self._area.move(F_R, noise)
        self._X[:3] = pose

    def _apply(self, numbers: IntArray, H: FloatArray, R: FloatArray, Z: FloatArray) -> None:
        """Correct X and P with an innovation Z of some landmarks (eqs. 3-25 … 3-29).

        ``H`` (m, 3 + 2k) acts on the robot and the k landmarks, ``R`` (m, m) is the noise.

        Raises
        ------
        VslamError
            When the innovation's covariance is not positive definite.
        """
        step = self._area.correct(self._at(numbers), H, R, Z)
        if step is None:
            raise VslamError("the innovation covariance is not positive definite; the filter has broken down")
        self._shift(step)

    def _shift(self, step: FloatArray) -> None:
        """X ← X + K Z (eq. 3-28), given the active area's rows of K Z."""
        self._X[self._area.rows] += step

    def _append(self, landmarks: FloatArray, G: FloatArray, noise: FloatArray) -> IntArray:
        """Append k landmarks: P_LX = G P_RX and P_LL = G P_RR Gᵀ + noise (eqs. 3-34 … 3-37).

        ``G`` is (2k, 3), ``noise`` (2k, 2k). Returns their numbers.
        """
        start, end = self._size, self._size + 2 * len(landmarks)
        if end - start > self._area.room:
            self._activate(np.arange(0), end - start)
        self._grow(end)
        numbers = np.arange((start - 3) // 2, (end - 3) // 2)
        self._place[numbers] = (len(self._area.rows) - 3) // 2 + np.arange(len(landmarks))
        self._area.append(np.arange(start, end), G, noise)
        self._X[start:end] = landmarks.ravel()
        self._size = end
        return numbers

    def _at(self, numbers: IntArray) -> IntArray:
        """Rows of the active area that hold the robot and the given landmarks, (3 + 2k,).

        The robot enters another area when one of them lies outside.
        """
        places = self._place[numbers]
        if len(places) and places.min() < 0:
            self._activate(numbers)
            places = self._place[numbers]
        return state_rows(places)

    def _activate(self, numbers: IntArray, room: int = 0) -> None:
        """Enter the area of some landmarks and those nearest to the robot."""
        self._settle()
        landmarks = self._X[3 : self._size].reshape(-1, 2)
        if 0 < self.nearest < len(landmarks):
            distances = ((landmarks - self._X[:2]) ** 2).sum(axis=1)
            numbers = np.union1d(numbers, np.argpartition(distances, self.nearest)[: self.nearest])
        elif self.nearest:
            numbers = np.arange(len(landmarks))
        else:
            numbers = np.unique(numbers)
        rows = state_rows(numbers)
        P_XA = np.empty((self._size, len(rows)))
        _gather(self._P, rows, P_XA)
        self._area = ActiveArea(rows, P_XA, max(_ROOM, room))
        self._place[:] = -1
        self._place[numbers] = np.arange(len(numbers))

    def _settled_blocks(self) -> FloatArray:
        """Diagonal blocks of P_MM when the area was entered."""
        n = len(self._area.P_XA0)
        variances = self._P.diagonal()[3:n].reshape(-1, 2)
        covariances = self._P.diagonal(-1)[3 : n - 1 : 2]
        blocks = np.empty((len(variances), 2, 2))
        blocks[:, 0, 0], blocks[:, 1, 1] = variances.T
        blocks[:, 0, 1] = blocks[:, 1, 0] = covariances
        return blocks

    def _settle_means(self) -> None:
        """Correct the landmarks outside the area."""
        if self._area.moved:
            shift = self._area.shift_of_others()
            self._X[: len(shift)] += shift

    def _settle(self) -> None:
        """Bring X and P up to date; the area stays."""
        area = self._area
        if not area.moved:
            return
        self._settle_means()
        part = area.loss_of_others()
        if part.shape[1]:
            loss = np.zeros((len(self._P), part.shape[1]), order="F")
            loss[: len(part)] = part
            self._P = dsyrk(-1.0, loss, beta=1.0, c=self._P, lower=1, overwrite_c=1)
        P_XA = area.columns()
        _scatter(P_XA, area.rows, self._P)
        self._area = ActiveArea(area.rows, P_XA, area.room)

    def _grow(self, size: int) -> None:
        capacity = -(-size // _CHUNK) * _CHUNK
        if capacity <= len(self._X):
            return
        n = len(self._X)
        X, P = np.zeros(capacity), np.zeros((capacity, capacity), order="F")
        place = np.full(capacity, -1, dtype=np.int64)
        X[:n], P[:n, :n], place[:n] = self._X, self._P, self._place
        self._X, self._P, self._place = X, P, place


@njit(cache=True)
def _gather(P: FloatArray, rows: IntArray, columns: FloatArray) -> None:
    """Columns of the symmetric P from its lower triangle."""
    for k in range(len(rows)):
        j = rows[k]
        for i in range(j):
            columns[i, k] = P[j, i]
        for i in range(j, len(columns)):
            columns[i, k] = P[i, j]


@njit(cache=True)
def _scatter(columns: FloatArray, rows: IntArray, P: FloatArray) -> None:
    """Put columns of the symmetric P into its lower triangle."""
    for k in range(len(rows)):
        j = rows[k]
        for i in range(j):
            P[j, i] = columns[i, k]
        for i in range(j, len(columns)):
            P[i, j] = columns[i, k]


@njit(cache=True)
def _take_from_blocks(blocks: FloatArray, loss: FloatArray) -> None:
    """Subtract the diagonal blocks of loss lossᵀ."""
    for n in range((len(loss) - 3) // 2):
        x, y = loss[3 + 2 * n], loss[4 + 2 * n]
        xx = xy = yy = 0.0
        for k in range(len(x)):
            xx += x[k] * x[k]
            xy += x[k] * y[k]
            yy += y[k] * y[k]
        blocks[n, 0, 0] -= xx
        blocks[n, 0, 1] -= xy
        blocks[n, 1, 0] -= xy
        blocks[n, 1, 1] -= yy


@njit(cache=True)
def _put_blocks(blocks: FloatArray, rows: IntArray, P_AA: FloatArray) -> None:
    """Set the blocks of the landmarks whose rows an active area holds."""
    for k in range(3, len(rows), 2):
        n = (rows[k] - 3) // 2
        blocks[n, 0, 0], blocks[n, 1, 1] = P_AA[k, k], P_AA[k + 1, k + 1]
        blocks[n, 0, 1] = blocks[n, 1, 0] = P_AA[k, k + 1]


@njit(cache=True)
def state_rows(numbers: IntArray) -> IntArray:
    """Rows of the state that hold the robot and the given landmarks, (3 + 2k,)."""
    rows = np.empty(3 + 2 * len(numbers), dtype=np.int64)
    rows[0], rows[1], rows[2] = 0, 1, 2
    for k in range(len(numbers)):
        rows[3 + 2 * k] = 3 + 2 * numbers[k]
        rows[4 + 2 * k] = 4 + 2 * numbers[k]
    return rows


@njit(cache=True)
def block_diagonal(blocks: FloatArray) -> FloatArray:
    """(k, 2, 2) blocks on the diagonal of a (2k, 2k) matrix."""
    k = len(blocks)
    matrix = np.zeros((2 * k, 2 * k))
    for i in range(k):
        matrix[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = blocks[i]
    return matrix


@njit(cache=True)
def stacked_jacobian(H_R: FloatArray, H_L: FloatArray) -> FloatArray:
    """H without its zero columns: [H_R | diag(H_L)], (2k, 3 + 2k)."""
    k = len(H_R)
    H = np.zeros((2 * k, 3 + 2 * k))
    for i in range(k):
        H[2 * i : 2 * i + 2, :3] = H_R[i]
        H[2 * i : 2 * i + 2, 3 + 2 * i : 5 + 2 * i] = H_L[i]
    return H


@njit(cache=True)
def _mirror(matrix: FloatArray) -> FloatArray:
    """Copy a symmetric matrix from its lower triangle."""
    n = matrix.shape[0]
    out = np.empty((n, n))
    for j in range(n):
        for i in range(j, n):
            out[i, j] = out[j, i] = matrix[i, j]
    return out
