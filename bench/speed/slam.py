"""``slam``: steps per second of the whole DLR log through ``ekf_fej``, against a block-update EKF in NumPy.

Both take the log's observations with annotated ids, one BLAS thread each. The baseline is the textbook filter
as one writes it in NumPy: the whole of P, one block per picture with a sparse H, P grown by ``np.pad``. It
does the same work but for the point of linearisation; ours checks its input besides.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from bench.sequences.drive import Drive
from bench.speed import slam_stage
from bench.speed.model import Benchmark, Configuration, Sides
from vslam.backends.parts.full_covariance import block_diagonal, stacked_jacobian, state_rows
from vslam.frame import Observations, Odometry
from vslam.motion import motion_jacobians, move
from vslam.observation import Cartesian

FloatArray = NDArray[np.float64]


class NumpyEkf:
    """The textbook filter on a whole covariance."""

    def __init__(self) -> None:
        self.model = Cartesian()
        self.x, self.P = np.zeros(3), np.zeros((3, 3))
        self._numbers: dict[int, int] = {}

    def step(self, odometry: Odometry, observations: Observations) -> None:
        """Predict, correct in one block, found."""
        F_R, F_n = motion_jacobians(self.x[:3], odometry.delta)
        self.P[:3] = F_R @ self.P[:3]
        self.P[:, :3] = self.P[:, :3] @ F_R.T
        self.P[:3, :3] += F_n @ odometry.covariance @ F_n.T
        self.x[:3] = move(self.x[:3], odometry.delta)
        known = np.array([i in self._numbers for i in observations.ids.tolist()], dtype=bool)
        if known.any():
            self._correct(
                observations.points[known], observations.covariances[known], observations.ids[known]
            )
        new = ~known & (observations.ids >= 0)
        if new.any():
            self._found(observations.points[new], observations.covariances[new], observations.ids[new])

    def _correct(self, z: FloatArray, S: FloatArray, ids: NDArray[np.int64]) -> None:
        numbers = np.array([self._numbers[i] for i in ids.tolist()])
        rows, landmarks = state_rows(numbers), self.x[3:].reshape(-1, 2)[numbers]
        H = stacked_jacobian(*self.model.h_jacobians(self.x[:3], landmarks))
        PHt = self.P[:, rows] @ H.T
        S_Z = H @ PHt[rows] + block_diagonal(S)
        # K S_Z Kᵀ = Wᵀ W; with K (P Hᵀ)ᵀ in its place P loses its symmetry and the filter diverges on the log
        C = np.linalg.cholesky(S_Z)
        W = np.linalg.solve(C, PHt.T)
        Z = (z - self.model.h(self.x[:3], landmarks)).ravel()
        self.x += W.T @ np.linalg.solve(C, Z)
        self.P -= W.T @ W

    def _found(self, z: FloatArray, S: FloatArray, ids: NDArray[np.int64]) -> None:
        n, k = len(self.x), 2 * len(z)
        G_R, G_z = self.model.g_jacobians(self.x[:3], z)
        G = G_R.reshape(-1, 3)
        self.x = np.concatenate([self.x, self.model.g(self.x[:3], z).ravel()])
        P = np.pad(self.P, ((0, k), (0, k)))
        P[n:, :n] = G @ self.P[:3]
        P[:n, n:] = P[n:, :n].T
        P[n:, n:] = G @ self.P[:3, :3] @ G.T + block_diagonal(G_z @ S @ G_z.transpose(0, 2, 1))
        self.P = P
        for i in ids.tolist():
            self._numbers[i] = len(self._numbers)


def baseline(over: Drive) -> int:
    """The NumPy filter over the drive."""
    ekf = NumpyEkf()
    with threadpool_limits(limits=1, user_api="blas"):
        for odometry, observations in over.steps:
            ekf.step(odometry, observations)
    return len(over.steps)


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Read the log."""
    over = slam_stage.drive(configuration)
    yield Sides(lambda: slam_stage.ours(over), lambda: baseline(over), slam_stage.note_of(over))


BENCHMARK = Benchmark(
    "slam",
    "the whole DLR log through ekf_fej, against a block-update EKF in NumPy",
    "steps/s",
    True,
    "ratio ≥ 5",
    prepare,
    rounds=3,
)
