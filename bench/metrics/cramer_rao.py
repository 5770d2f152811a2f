"""The posterior Cramér–Rao bound: what no online estimator of the robot's position can undercut.

Sources
-------
Tichavský, Muravchik & Nehorai 1998, "Posterior Cramér–Rao bounds for discrete-time nonlinear filtering",
eqs. 21 … 36. Its information recursion, for additive Gaussian noise and with the Jacobians at the true state,
is the inverse of the covariance recursion of an extended Kalman filter that linearises at the truth (Taylor
1979). For SLAM: Huang & Dissanayake 2007, section III.

Conventions
-----------
- Such a filter is `ekf` on observations without noise: its estimate is the truth then, at each step, while
  its covariances are those that the stream states. What the bound depends on is which landmark is seen when.
- The expectation over drives is taken at the one true track that there is. A biased estimator, or a lucky
  run, may fall below; the mean over runs of an unbiased one does not.
- Observations without a known landmark are left out: the bound is that of annotated ids.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.sequences.drive import Drive
from bench.sequences.simulated import true_increment
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local
from vslam.slam import SlamSettings, run_slam

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def bound(drive: Drive) -> FloatArray:
    """Smallest covariance of the pose after each step, given all up to it.

    Returns
    -------
    (n, 3, 3) float64, m², m·rad and rad².

    Raises
    ------
    VslamError
        For steps that a filter refuses.
    """
    settings = SlamSettings("ekf", "annotated", "cartesian")
    return run_slam(without_noise(drive), settings).covariances


def position_bound(drive: Drive) -> float:
    """Bound beside the position RMSE (eq. 3-39): √ of the mean over the steps of P_xx + P_yy, metres."""
    P = bound(drive)
    return float(np.sqrt((P[:, 0, 0] + P[:, 1, 1]).mean()))


def without_noise(drive: Drive) -> list[tuple[Odometry, Observations]]:
    """The stream as a perfect sensor would have given it, with the covariances that it states."""
    starts = np.vstack([np.zeros((1, 3)), drive.truth[:-1]])
    return [
        (
            Odometry(true_increment(start, pose), odometry.covariance),
            _seen(pose, observations, rows, drive.landmark_positions),
        )
        for (odometry, observations), start, pose, rows in zip(
            drive.steps, starts, drive.truth, drive.seen, strict=True
        )
    ]


def _seen(
    pose: FloatArray, observations: Observations, rows: IntArray, landmarks: FloatArray
) -> Observations:
    known = rows >= 0
    points = to_local(pose, landmarks[rows[known]])
    return Observations(points, observations.covariances[known], observations.ids[known])
