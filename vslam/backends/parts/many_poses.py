"""One observation model from many poses at once: for sigma points and particles.

Both forms measure a landmark by where it lies in the robot's frame, h(R, L) = φ(Rot(θ)ᵀ (L − p)), so the
model is asked about local points from a robot at the origin, all in one call.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.observation import ObservationModel

FloatArray = NDArray[np.float64]

_ORIGIN = np.zeros(3)


def measure(model: ObservationModel, poses: FloatArray, landmarks: FloatArray) -> FloatArray:
    """H of k landmarks from m poses, (m, 3) and (m, k, 2) to (m, k, 2)."""
    local = _to_local(poses, landmarks)
    return model.h(_ORIGIN, local.reshape(-1, 2)).reshape(local.shape)


def jacobians(
    model: ObservationModel, poses: FloatArray, landmarks: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """H_R (m, k, 2, 3) and H_L (m, k, 2, 2) of k landmarks from m poses."""
    local = _to_local(poses, landmarks)
    R_origin, L_origin = model.h_jacobians(_ORIGIN, local.reshape(-1, 2))
    H_L = L_origin.reshape(*local.shape, 2) @ _rotations(poses).transpose(0, 2, 1)[:, None]
    H_R = np.empty((*local.shape, 3))
    H_R[..., :2] = -H_L
    H_R[..., 2] = R_origin.reshape(*local.shape, 3)[..., 2]  # turning the robot is the same in its own frame
    return H_R, H_L


def place(model: ObservationModel, poses: FloatArray, z: FloatArray) -> FloatArray:
    """G of k measurements from m poses, (m, 3) and (m, k, 2) to (m, k, 2)."""
    local = model.g(_ORIGIN, z.reshape(-1, 2)).reshape(z.shape)
    return local @ _rotations(poses).transpose(0, 2, 1) + poses[:, None, :2]


def place_jacobians(model: ObservationModel, poses: FloatArray, z: FloatArray) -> FloatArray:
    """G_z (m, k, 2, 2) of k measurements (k, 2) from m poses."""
    _, G_z = model.g_jacobians(_ORIGIN, z)
    return np.asarray(_rotations(poses)[:, None] @ G_z[None])


def _to_local(poses: FloatArray, landmarks: FloatArray) -> FloatArray:
    return np.asarray((landmarks - poses[:, None, :2]) @ _rotations(poses))


def _rotations(poses: FloatArray) -> FloatArray:
    """Rot(θ) of each pose, (m, 2, 2)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
