"""FastSLAM 2.0: particles are drawn where odometry and picture agree.

Source: Montemerlo, Thrun, Koller & Wegbreit 2003, "FastSLAM 2.0: an improved particle filtering algorithm for
simultaneous localization and mapping that provably converges", eqs. 8 … 20; Thrun, Burgard & Fox 2005,
*Probabilistic Robotics*, section 13.5. `particles` holds what it shares with FastSLAM 1.0.

A motion is only noted until its picture comes. Each particle then has a Gaussian over its pose, from the
odometry, that the matched observations correct one after the other; the pose is drawn from what results, and
the weight is the product of the observations' predictive densities.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts import many_poses
from vslam.backends.parts.input_checks import check_odometry
from vslam.backends.parts.particles import PARTICLES, Particles, log_gaussian
from vslam.backends.parts.sigma_points import factor
from vslam.frame import Odometry
from vslam.motion import move
from vslam.observation import ObservationModel
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@backends.register("fastslam2")
class FastSlam2(Particles):
    """The Rao-Blackwellised particle filter whose proposal knows the picture."""

    name = "fastslam2"

    def __init__(self, model: ObservationModel, seed: int = 0, particles: int = PARTICLES) -> None:
        super().__init__(model, seed, particles)
        self._spread: FloatArray | None = None  # (N, 3, 3) of poses not yet drawn

    def predict(self, odometry: Odometry) -> None:
        """Note a motion; the one before is drawn if no picture came with it.

        Raises
        ------
        VslamError
            When the increment is not finite or its covariance not positive semi-definite.
        """
        check_odometry(odometry)
        self._draw()
        headings = self._poses[:, 2]
        F_n = np.zeros((len(headings), 3, 3))
        F_n[:, 0, 0] = F_n[:, 1, 1] = np.cos(headings)
        F_n[:, 1, 0] = np.sin(headings)
        F_n[:, 0, 1] = -F_n[:, 1, 0]
        F_n[:, 2, 2] = 1.0
        self._poses = move(self._poses.T, odometry.delta[:, None]).T
        self._spread = F_n @ odometry.covariance @ F_n.transpose(0, 2, 1)
        self._kernel = np.tensordot(self.weights, self._spread, axes=1)

    def _sample(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> FloatArray:
        weights = np.zeros(len(self._poses))
        if self._spread is None:  # a second picture from the same place
            self._spread = np.zeros((len(self._poses), 3, 3))
        for one in range(len(z)):
            weights += self._agree(z[one], S[one], int(numbers[one]), self._spread)
        self._kernel = np.tensordot(self.weights, self._spread, axes=1)
        self._draw()
        return weights

    def _agree(self, z: FloatArray, S: FloatArray, number: int, spread: FloatArray) -> FloatArray:
        """Correct each particle's proposal with one observation; the logarithm of its density, (N,)."""
        mean = self._means[:, number : number + 1]
        H_R, H_L = (H[:, 0] for H in many_poses.jacobians(self.model, self._poses, mean))
        Z = self.model.innovation(z, many_poses.measure(self.model, self._poses, mean)[:, 0])
        of_landmark = H_L @ self._covariances[:, number] @ H_L.transpose(0, 2, 1) + S
        PHt = spread @ H_R.transpose(0, 2, 1)
        S_Z = H_R @ PHt + of_landmark
        K = PHt @ np.linalg.inv(S_Z)
        self._poses = self._poses + (K @ Z[:, :, None])[:, :, 0]
        left = np.eye(3) - K @ H_R
        spread[:] = left @ spread @ left.transpose(0, 2, 1) + K @ of_landmark @ K.transpose(0, 2, 1)
        return log_gaussian(Z, S_Z)

    def _draw(self) -> None:
        if self._spread is not None:
            self._poses = self._poses + self._noise(_roots(self._spread))
            self._spread = None


def _roots(spread: FloatArray) -> FloatArray:
    """Cholesky factors, (N, 3, 3); of covariances without full rank, too."""
    try:
        return np.asarray(np.linalg.cholesky(spread), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.stack([factor(P) for P in spread])
