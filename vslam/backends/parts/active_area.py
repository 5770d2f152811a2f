"""The robot and the landmarks around it, filtered by themselves (compressed filter, Guivant & Nebot 2001).

"Optimization of the simultaneous localization and map-building algorithm for real-time implementation",
section IV: as long as the robot sees landmarks of an area A alone, no motion and no correction needs the rest
of the map, B. What they do to B is linear in what B was when the area was entered (index 0), and is collected
in matrices of A's size:

    P_BA = P_BA0 Φᵀ,   P_BB = P_BB0 − P_BA0 Vᵀ V P_AB0,   X_B = X_B0 + P_BA0 θ.

A motion F and a correction with H, S_Z = H P_AA Hᵀ + R = C Cᵀ and W = P_AA Hᵀ C⁻ᵀ do

    P_AA ← F P_AA Fᵀ + noise,   Φ ← F Φ;
    P_AA ← P_AA − W Wᵀ,         Φ ← Φ − W v,   V ← [V; v],   θ ← θ + vᵀ C⁻¹ Z   with v = C⁻¹ H Φ.

Nothing is approximated. The paper's Ψ = Vᵀ V is kept as its factor V, which loses no digits by squaring.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Rows of V that are collected before a QR compresses them to as many as A had at first.
_COLLECTED = 512


class ActiveArea:
    """Covariance of the robot and some landmarks, and what has to be done to that of all others.

    Parameters
    ----------
    rows : (n,) int64
        Rows of the state in A, the robot's three first.
    P_XA : (size, n) float64
        Their columns of P, for all rows of the state.
    room : int
        Rows that can be appended; they come last in the state.
    """

    def __init__(self, rows: IntArray, P_XA: FloatArray, room: int) -> None:
        n = len(rows)
        self.P_XA0 = P_XA
        self._rows = np.empty(n + room, dtype=np.int64)
        self._rows[:n] = rows
        # [Φ | P_AA]: motions and corrections treat both alike
        self._joint = np.empty((n + room, n + n + room))
        self._joint[:n, :n] = np.eye(n)
        self._joint[:n, n : 2 * n] = P_XA[rows]
        self._first = self._size = n
        self._V = np.empty((_COLLECTED, n))
        self._collected = 0
        self.told = 0
        """Rows of V that `untold_loss_of_others` has told of; 0 again where it has to start anew."""
        self._theta = np.zeros(n)
        self.moved = False

    @property
    def rows(self) -> IntArray:
        """Rows of the state in A, (n,) int64."""
        return self._rows[: self._size]

    @property
    def room(self) -> int:
        """Rows that can still be appended."""
        return len(self._rows) - self._size

    @property
    def P_AA(self) -> FloatArray:
        """(n, n) float64, a view; symmetric to the last bit."""
        return self._joint[: self._size, self._first : self._first + self._size]

    @property
    def Phi(self) -> FloatArray:
        """Φ, (n, n at first) float64, a view."""
        return self._joint[: self._size, : self._first]

    @property
    def V(self) -> FloatArray:
        """V, (rows so far, n at first) float64, a view."""
        return self._V[: self._collected]

    @property
    def memory_bytes(self) -> int:
        """Bytes of all matrices."""
        return self.P_XA0.nbytes + self._joint.nbytes + self._V.nbytes

    def move(self, F: FloatArray, noise: FloatArray) -> None:
        """Move the robot: F (3, 3), noise (3, 3)."""
        self.moved = True
        _move(self._joint, self._first, self._size, F, noise)

    def correct(self, at: IntArray, H: FloatArray, R: FloatArray, Z: FloatArray) -> FloatArray | None:
        """Correct with m measurements of the rows ``at`` of A.

        Parameters
        ----------
        at : (k,) int64
            Rows of A that H acts on.
        H : (m, k) float64
        R : (m, m) float64
            Noise.
        Z : (m,) float64
            Innovation (eq. 3-22).

        Returns
        -------
        (n,) float64
            What is to be added to A's means, K Z; None if S_Z is not positive definite, and nothing is done.
        """
        m = len(Z)
        if self._collected + m > len(self._V):
            self._compress(m)
        v = self._V[self._collected : self._collected + m]
        step, definite = _correct(self._joint, self._first, self._size, at, H, R, Z, v, self._theta)
        if not definite:
            return None
        self.moved = True
        self._collected += m
        return np.asarray(step)

    def append(self, rows: IntArray, G: FloatArray, noise: FloatArray) -> None:
        """Append rows that are G R plus noise: G (k, 3), noise (k, k) (eqs. 3-34 … 3-37)."""
        self.moved = True
        start, end, f = self._size, self._size + len(rows), self._first
        joint = self._joint
        joint[start:end, : f + start] = G @ joint[:3, : f + start]
        joint[:start, f + start : f + end] = joint[start:end, f : f + start].T
        own = joint[start:end, f : f + 3] @ G.T + noise
        joint[start:end, f + start : f + end] = 0.5 * (own + own.T)
        self._rows[start:end] = rows
        self._size = end

    def columns(self, count: int | None = None) -> FloatArray:
        """P_XA as it is now, P_BA0 Φᵀ and P_AA in A's own rows; (size, n), or the first ``count`` columns."""
        P_XA = np.zeros((len(self.P_XA0) + self._size - self._first, self.Phi[:count].shape[0]))
        P_XA[: len(self.P_XA0)] = self.P_XA0 @ self.Phi[:count].T
        P_XA[self.rows] = self.P_AA[:, :count]
        return P_XA

    def shift_of_others(self) -> FloatArray:
        """X_B − X_B0 = P_BA0 θ, (size at first,), 0 in A's own rows; θ starts anew."""
        shift = self.P_XA0 @ self._theta
        shift[self.rows[: self._first]] = 0.0
        self._theta[:] = 0.0
        return np.asarray(shift)

    def loss_of_others(self) -> FloatArray:
        """P_BA0 Vᵀ, (size at first, r), 0 in A's own rows: P_BB has lost its product with its transpose."""
        if self._collected > self._first:
            self._compress(0)
        return self._loss(self.V)

    def untold_loss_of_others(self) -> FloatArray:
        """The same of what was corrected since the last call alone, or since the start if `told` is 0."""
        untold, self.told = self.V[self.told :], self._collected
        return self._loss(untold)

    def _loss(self, V: FloatArray) -> FloatArray:
        loss = self.P_XA0 @ V.T
        loss[self.rows[: self._first]] = 0.0
        return np.asarray(loss)

    def _compress(self, room: int) -> None:
        """V ← R of V = Q R, as Vᵀ V is all that counts; make room for some rows."""
        R = np.linalg.qr(self.V, mode="r")
        if len(R) + room > len(self._V):
            self._V = np.empty((2 * (len(R) + room), self._first))
        self._V[: len(R)] = R
        self.told = len(R) if self.told == self._collected else 0
        self._collected = len(R)


@njit(cache=True)
def _move(joint: FloatArray, first: int, size: int, F: FloatArray, noise: FloatArray) -> None:
    """Φ ← F Φ, P_RX ← F P_RX, P_RR ← F P_RR Fᵀ + noise."""
    robot = joint[:3, : first + size].copy()
    for i in range(3):
        for j in range(first + size):
            joint[i, j] = F[i, 0] * robot[0, j] + F[i, 1] * robot[1, j] + F[i, 2] * robot[2, j]
    turned = joint[:3, first : first + 3].copy()
    for i in range(3):
        for j in range(i + 1):
            value = F[j, 0] * turned[i, 0] + F[j, 1] * turned[i, 1] + F[j, 2] * turned[i, 2] + noise[i, j]
            joint[i, first + j] = joint[j, first + i] = value
    for i in range(3):
        for j in range(3, size):
            joint[j, first + i] = joint[i, first + j]


@njit(cache=True)
def _correct(joint, first, size, at, H, R, Z, v, theta):  # type: ignore[no-untyped-def]
    """See `ActiveArea.correct`; v is V's new rows, theta is updated."""
    m, width = len(Z), first + size
    G = np.zeros((m, width))  # H [Φ | P_AA], then C⁻¹ times that: [v | Wᵀ]
    for a in range(m):
        for k in range(len(at)):
            h = H[a, k]
            if h != 0.0:
                row = joint[at[k]]
                for j in range(width):
                    G[a, j] += h * row[j]
    C = R.copy()  # S_Z (eq. 3-25), then its Cholesky factor
    for a in range(m):
        for b in range(a + 1):
            total = C[a, b]
            for k in range(len(at)):
                total += G[a, first + at[k]] * H[b, k]
            C[a, b] = total
    y = Z.copy()  # C⁻¹ Z
    for a in range(m):
        for b in range(a + 1):
            total = C[a, b]
            for k in range(b):
                total -= C[a, k] * C[b, k]
            if a != b:
                C[a, b] = total / C[b, b]
            elif total > 0.0:
                C[a, a] = np.sqrt(total)
            else:
                return y, False
    for a in range(m):
        for b in range(a):
            c = C[a, b]
            y[a] -= c * y[b]
            for j in range(width):
                G[a, j] -= c * G[b, j]
        scale = 1.0 / C[a, a]
        y[a] *= scale
        for j in range(width):
            G[a, j] *= scale
    v[:] = G[:, :first]
    step = np.zeros(size)
    for a in range(m):
        for j in range(first):
            theta[j] += y[a] * G[a, j]
        for j in range(size):
            step[j] += y[a] * G[a, first + j]
    for i in range(size):
        row = joint[i]
        for a in range(m):
            w = G[a, first + i]
            for j in range(width):
                row[j] -= w * G[a, j]
    return step, True
