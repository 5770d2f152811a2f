"""FastSLAM 1.0: particles move by the odometry's noise and are weighed by what they see.

Source: Montemerlo, Thrun, Koller & Wegbreit 2002, section 3; Thrun, Burgard & Fox 2005, *Probabilistic
Robotics*, table 13.1. `particles` holds what it shares with FastSLAM 2.0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts import many_poses
from vslam.backends.parts.input_checks import check_odometry
from vslam.backends.parts.particles import Particles, log_gaussian
from vslam.backends.parts.sigma_points import factor
from vslam.frame import Odometry
from vslam.motion import motion_jacobians, move
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@backends.register("fastslam1")
class FastSlam1(Particles):
    """The Rao-Blackwellised particle filter whose proposal is the motion model."""

    name = "fastslam1"

    def predict(self, odometry: Odometry) -> None:
        """Draw each particle's motion.

        Raises
        ------
        VslamError
            When the increment is not finite or its covariance not positive semi-definite.
        """
        check_odometry(odometry)
        _, F_n = motion_jacobians(self.pose, odometry.delta)
        self._kernel = bandwidth(len(self._poses)) ** 2 * F_n @ odometry.covariance @ F_n.T
        noise = self._noise(factor(odometry.covariance))
        self._poses = move(self._poses.T, odometry.delta[:, None], noise.T).T

    def _sample(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> FloatArray:
        """Poses are drawn already; weights Π N(z; ẑ, H_L P_LL H_Lᵀ + S)."""
        if not len(z):
            return np.zeros(len(self._poses))
        means = self._means[:, numbers]
        _, H = many_poses.jacobians(self.model, self._poses, means)
        Z = self.model.innovation(z, many_poses.measure(self.model, self._poses, means))
        S_Z = H @ self._covariances[:, numbers] @ H.swapaxes(-1, -2) + S
        return np.asarray(log_gaussian(Z, S_Z).sum(axis=1))


def bandwidth(particles: int) -> float:
    """Optimal width of a Gaussian kernel about N samples of three dimensions, in standard deviations.

    (4 / (d + 2))^(1/(d + 4)) N^(−1/(d + 4)), Musso, Oudjane & Le Gland 2001, eq. 12.2.7 (Silverman 1986).
    """
    return float((4.0 / (5.0 * particles)) ** (1.0 / 7.0))
