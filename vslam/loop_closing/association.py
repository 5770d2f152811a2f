"""Association ``constellation``: decided over the whole drive, with an estimator of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vslam.association import associations
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.loop_closing.drive import Drive
from vslam.slam_backend import Backend

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class DriveEstimate:
    """A whole drive.

    Attributes
    ----------
    online_poses, online_covariances : (n, 3), (n, 3, 3) float64
        As they were known when each step was taken.
    poses : (n, 3) float64
        With hindsight; headings not wrapped.
    landmarks : (m, 2) float64, metres
    landmark_covariances : (m, 2, 2) float64, m²
    matches : tuple of n (n_k,) int64
        Landmark of each observation with hindsight, −1 for none.
    """

    online_poses: FloatArray
    online_covariances: FloatArray
    poses: FloatArray
    landmarks: FloatArray
    landmark_covariances: FloatArray
    matches: tuple[IntArray, ...]


@associations.register("constellation")
class Constellation:
    """Recognises places by their discs (`vslam.loop_closing.drive`); the back-end plays no part.

    Parameters
    ----------
    gate, new_gate : float
        As in `vslam.slam.SlamSettings`.
    """

    def __init__(self, gate: float, new_gate: float) -> None:
        self._gates = gate, new_gate

    def associate(self, backend: Backend, observations: Observations) -> IntArray:
        """Refuse: a picture alone decides nothing here.

        Raises
        ------
        VslamError
            Always.
        """
        raise VslamError("association 'constellation' needs the whole drive: call run_slam, or choose 'jcbb'")

    def run(self, steps: Sequence[tuple[Odometry, Observations]]) -> DriveEstimate:
        """Estimate track, map and pairings.

        Raises
        ------
        VslamError
            Naming the step, counted from 0, whose input cannot be used.
        """
        drive = Drive(*self._gates)
        for k, (odometry, observations) in enumerate(steps):
            try:
                drive.step(odometry, observations)
            except VslamError as error:
                raise VslamError(f"SLAM step {k}: {error}") from error
        estimate, matches = drive.finish()
        count = len(estimate.landmarks)
        return DriveEstimate(
            np.array(drive.online_poses).reshape(-1, 3),
            np.array(drive.online_covariances).reshape(-1, 3, 3),
            estimate.poses[1:],
            estimate.landmarks,
            np.array([estimate.covariance(np.array([j])) for j in range(count)]).reshape(-1, 2, 2),
            tuple(matches),
        )
