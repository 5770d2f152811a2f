"""Observation models z = h(R, L) + v, v ~ N(0, S), with their inverses and Jacobians.

Two forms of the same measurement, a landmark seen from the robot:

``range_bearing``
    z = (distance, bearing), metres and rad (eqs. 3-12, 3-13).
``cartesian``
    z = (forward, left), metres: the landmark in the robot's frame (eqs. 3-6, 3-7).

All functions take many landmarks at once, n of them, and one pose (x, y in metres, heading in rad).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.frame import Observations
from vslam.geometry import rotation, to_global, to_local, wrap_angle
from vslam.slam_registry import Registry

FloatArray = NDArray[np.float64]

# Metres. A landmark right under the robot has no bearing; closer than this, the Jacobian is taken at it.
_NEAREST = 1e-6


class ObservationModel(Protocol):
    """What a back-end needs to know about a measurement."""

    @property
    def name(self) -> str:
        """Name in the registry."""

    def measure(self, observations: Observations) -> tuple[FloatArray, FloatArray]:
        """Observations as measurements z (n, 2) with covariances S (n, 2, 2)."""

    def h(self, pose: FloatArray, landmarks: FloatArray) -> FloatArray:
        """Predict the measurements (n, 2) of landmarks (n, 2) in the world."""

    def h_jacobians(self, pose: FloatArray, landmarks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """H_R = ∂h/∂R (n, 2, 3) and H_L = ∂h/∂L (n, 2, 2)."""

    def g(self, pose: FloatArray, z: FloatArray) -> FloatArray:
        """Landmarks (n, 2) in the world from measurements (n, 2): the inverse of h."""

    def g_jacobians(self, pose: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """G_R = ∂g/∂R (n, 2, 3) and G_z = ∂g/∂z (n, 2, 2)."""

    def innovation(self, z: FloatArray, expected: FloatArray) -> FloatArray:
        """Z = z − h (…, 2), angles wrapped into [−π, π)."""


observation_models: Registry[type[ObservationModel]] = Registry("observation model")


@observation_models.register("range_bearing")
class RangeBearing:
    """Distance (metres) and bearing (rad, counter-clockwise from straight ahead), eqs. 3-12 and 3-13."""

    name = "range_bearing"

    def measure(self, observations: Observations) -> tuple[FloatArray, FloatArray]:
        """Polar form of the points; S = J S_xy Jᵀ with J the Jacobian of the conversion.

        Raises
        ------
        VslamError
            When a point lies at the robot's origin, where no bearing exists.
        """
        z = _polar(observations.points)
        if len(z) and z[:, 0].min() < _NEAREST:
            raise VslamError("an observed landmark lies at the robot's origin and has no bearing; drop it")
        J = _polar_jacobian(observations.points)
        return z, J @ observations.covariances @ J.transpose(0, 2, 1)

    def h(self, pose: FloatArray, landmarks: FloatArray) -> FloatArray:
        """Distance and bearing of landmarks (eq. 3-12); (n, 2), bearing in [−π, π)."""
        z = _polar(landmarks - pose[:2])
        z[:, 1] = wrap_angle(z[:, 1] - pose[2])
        return z

    def h_jacobians(self, pose: FloatArray, landmarks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """H_R (n, 2, 3) and H_L (n, 2, 2) of eq. 3-12."""
        H_L = _polar_jacobian(landmarks - pose[:2])
        H_R = np.zeros((len(landmarks), 2, 3))
        H_R[:, :, :2] = -H_L
        H_R[:, 1, 2] = -1.0
        return H_R, H_L

    def g(self, pose: FloatArray, z: FloatArray) -> FloatArray:
        """Landmarks in the world (eq. 3-13); (n, 2)."""
        heading = pose[2] + z[:, 1]
        return pose[:2] + z[:, :1] * np.stack([np.cos(heading), np.sin(heading)], axis=1)

    def g_jacobians(self, pose: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """G_R (n, 2, 3) and G_z (n, 2, 2) of eq. 3-13."""
        c, s = np.cos(pose[2] + z[:, 1]), np.sin(pose[2] + z[:, 1])
        G_z = np.empty((len(z), 2, 2))
        G_z[:, 0, 0], G_z[:, 1, 0] = c, s
        G_z[:, 0, 1], G_z[:, 1, 1] = -z[:, 0] * s, z[:, 0] * c
        # Turning the robot turns the bearing: the heading's column equals the bearing's.
        return _pose_jacobian(G_z[:, :, 1]), G_z

    def innovation(self, z: FloatArray, expected: FloatArray) -> FloatArray:
        """Z = z − h, the bearing wrapped into [−π, π)."""
        difference = z - expected
        difference[..., 1] = wrap_angle(difference[..., 1])
        return difference


@observation_models.register("cartesian")
class Cartesian:
    """Forward and left coordinate in the robot's frame, metres, eqs. 3-6 and 3-7."""

    name = "cartesian"

    def measure(self, observations: Observations) -> tuple[FloatArray, FloatArray]:
        """Return the points as they are."""
        return observations.points, observations.covariances

    def h(self, pose: FloatArray, landmarks: FloatArray) -> FloatArray:
        """Landmarks in the robot's frame (eq. 3-6); (n, 2) metres."""
        return to_local(pose, landmarks)

    def h_jacobians(self, pose: FloatArray, landmarks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """H_R (n, 2, 3) and H_L (n, 2, 2) of eq. 3-6."""
        local = to_local(pose, landmarks)
        to_robot = rotation(pose[2]).T
        H_R = np.empty((len(landmarks), 2, 3))
        H_R[:, :, :2] = -to_robot
        H_R[:, 0, 2], H_R[:, 1, 2] = local[:, 1], -local[:, 0]
        return H_R, np.repeat(to_robot[None], len(landmarks), axis=0)

    def g(self, pose: FloatArray, z: FloatArray) -> FloatArray:
        """Landmarks in the world (eq. 3-7); (n, 2)."""
        return to_global(pose, z)

    def g_jacobians(self, pose: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """G_R (n, 2, 3) and G_z (n, 2, 2) of eq. 3-7."""
        to_world = rotation(pose[2])
        turned = z @ to_world.T
        by_heading = np.stack([-turned[:, 1], turned[:, 0]], axis=1)
        return _pose_jacobian(by_heading), np.repeat(to_world[None], len(z), axis=0)

    def innovation(self, z: FloatArray, expected: FloatArray) -> FloatArray:
        """Z = z − h."""
        return z - expected


def _polar(points: FloatArray) -> FloatArray:
    return np.stack([np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])], axis=1)


def _polar_jacobian(points: FloatArray) -> FloatArray:
    """∂(distance, angle)/∂(x, y), (n, 2, 2)."""
    x, y = points[:, 0], points[:, 1]
    r = np.maximum(np.hypot(x, y), _NEAREST)
    J = np.empty((len(points), 2, 2))
    J[:, 0, 0], J[:, 0, 1] = x / r, y / r
    J[:, 1, 0], J[:, 1, 1] = -y / r**2, x / r**2
    return J


def _pose_jacobian(by_heading: FloatArray) -> FloatArray:
    """G_R = [I | ∂g/∂θ]: the robot's translation moves the landmark with it."""
    G_R = np.zeros((len(by_heading), 2, 3))
    G_R[:, 0, 0] = G_R[:, 1, 1] = 1.0
    G_R[:, :, 2] = by_heading
    return G_R
