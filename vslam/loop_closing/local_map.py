"""A small map in the robot's own frame, in which association is easy.

Robocentric (Castellanos, Martinez-Cantin, Tardós & Neira 2007): the state is the discs around the robot as it
sees them, not the robot among the discs. The measurement is then linear, no absolute heading enters, and the
covariance stays as small as the motion since each disc was last seen, however far the robot has come.
A disc that has grown too vague is forgotten; when the robot returns it founds another *fragment*, and
that both are one disc is for the loop closer to find out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vslam.frame import Observations, Odometry
from vslam.geometry import rotation
from vslam.joint_compatibility import BUDGET, branch_and_bound, joint_bounds

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


VAGUE_M = 0.25
"""A disc whose σ, along its worst axis, exceeds this is forgotten. At 0.25 m the 99 % gate of a sight reaches
0.78 m, about as far as the next disc lies (0.85 m, the median of the DLR discs' nearest neighbours)."""


class LocalMap:
    """Tracks discs from picture to picture.

    Parameters
    ----------
    gate, new_gate : float
        As in `vslam.slam.SlamSettings`.
    """

    def __init__(self, gate: float, new_gate: float) -> None:
        self._gate, self._bounds = gate, joint_bounds(gate, 32)
        self._new = float(chi2.ppf(new_gate, 2))
        self.numbers = np.zeros(0, dtype=np.int64)
        self.points = np.zeros((0, 2))
        self.P = np.zeros((0, 0))
        self.founded = 0

    def step(self, odometry: Odometry, observations: Observations) -> IntArray:
        """Move, associate, correct; fragment of each observation, −1 where it is ambiguous, (n,) int64."""
        self._predict(odometry)
        self._forget()
        S = observations.covariances
        chosen, near = self._associate(observations.points, S)
        matches = np.full(len(observations), -1, dtype=np.int64)
        paired = chosen >= 0
        matches[paired] = self.numbers[chosen[paired]]
        if paired.any():
            self._correct(observations.points[paired], S[paired], chosen[paired])
        new = ~paired & ~near
        matches[new] = self._found(observations.points[new], S[new])
        return matches

    def _predict(self, odometry: Odometry) -> None:
        d, R = odometry.delta, rotation(odometry.delta[2])
        self.points = (self.points - d[:2]) @ R
        m = len(self.points)
        if not m:
            return
        blocks = np.empty((m, 2, 3))
        blocks[:, :, :2] = -R.T
        blocks[:, 0, 2], blocks[:, 1, 2] = self.points[:, 1], -self.points[:, 0]
        G = blocks.reshape(-1, 3)
        # Rᵀ P R of each 2 × 2 block, from the right and, as P is symmetric, once more from the right.
        half = (self.P.reshape(-1, 2) @ R).reshape(2 * m, 2 * m).T
        self.P = (np.ascontiguousarray(half).reshape(-1, 2) @ R).reshape(
            2 * m, 2 * m
        ) + G @ odometry.covariance @ G.T

    def _forget(self) -> None:
        keep = np.sqrt(_largest(self._blocks())) <= VAGUE_M
        if keep.all():
            return
        self.numbers, self.points = self.numbers[keep], self.points[keep]
        rows = np.repeat(keep, 2)
        self.P = self.P[np.ix_(rows, rows)]

    def _associate(self, points: FloatArray, S: FloatArray) -> tuple[IntArray, NDArray[np.bool_]]:
        n, m = len(points), len(self.points)
        if not n or not m:
            return np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=bool)
        if n >= len(self._bounds):
            self._bounds = joint_bounds(self._gate, 2 * n)
        Z = points[:, None] - self.points[None]
        C = self._blocks()[None] + S[:, None]
        distances = np.einsum("nmi,nmi->nm", Z, np.linalg.solve(C, Z[..., None])[..., 0])
        chosen, _ = branch_and_bound(
            Z, self.P, S, distances, distances <= self._bounds[1], self._bounds, BUDGET
        )
        return chosen, (distances <= self._new).any(axis=1)

    def _correct(self, z: FloatArray, S: FloatArray, which: IntArray) -> None:
        rows = (2 * which[:, None] + np.arange(2)).ravel()
        Z = (z - self.points[which]).ravel()
        C = self.P[np.ix_(rows, rows)].copy()
        for k in range(len(S)):
            C[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] += S[k]
        K = np.linalg.solve(C, self.P[rows]).T
        self.points = self.points + (K @ Z).reshape(-1, 2)
        P = self.P - K @ C @ K.T
        self.P = 0.5 * (P + P.T)

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        k, m = len(z), len(self.points)
        numbers = self.founded + np.arange(k)
        self.founded += k
        P = np.zeros((2 * (m + k), 2 * (m + k)))
        P[: 2 * m, : 2 * m] = self.P
        for i in range(k):
            a = 2 * (m + i)
            P[a : a + 2, a : a + 2] = S[i]
        self.P, self.points = P, np.vstack([self.points, z])
        self.numbers = np.append(self.numbers, numbers)
        return numbers

    def _blocks(self) -> FloatArray:
        m = len(self.points)
        each = np.arange(m)
        return self.P.reshape(m, 2, m, 2)[each, :, each, :]


def _largest(blocks: FloatArray) -> FloatArray:
    """Larger eigenvalue of symmetric (m, 2, 2)."""
    half = 0.5 * (blocks[:, 0, 0] + blocks[:, 1, 1])
    return half + np.sqrt((0.5 * (blocks[:, 0, 0] - blocks[:, 1, 1])) ** 2 + blocks[:, 0, 1] ** 2)
