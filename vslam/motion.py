"""The motion model R_t = f(R_{t−1}, u_t, n), n ~ N(0, Q), and its Jacobians (eqs. 3-8 … 3-11).

The increment u = (Δx, Δy, Δθ) is the robot's new pose in the frame of its old one; the dissertation's
u = [Δx, Δθ] is the case Δy = 0. The noise adds to the increment. The heading is not wrapped: it counts turns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def move(pose: FloatArray, delta: FloatArray, noise: FloatArray | None = None) -> FloatArray:
    """f(R, u, n): the pose after an increment (eqs. 3-8, 3-9).

    Parameters
    ----------
    pose : (3,) float64
        x, y (metres), heading (rad).
    delta : (3,) float64
        Δx forward, Δy left (metres), Δθ (rad).
    noise : (3,) float64, optional
        n, added to ``delta``.

    Returns
    -------
    (3,) float64.
    """
    dx, dy, dtheta = delta if noise is None else delta + noise
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([pose[0] + c * dx - s * dy, pose[1] + s * dx + c * dy, pose[2] + dtheta])


def motion_jacobians(pose: FloatArray, delta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """F_R = ∂f/∂R and F_n = ∂f/∂n at n = 0 (eqs. 3-10, 3-11).

    Parameters
    ----------
    pose, delta : (3,) float64
        As in `move`.

    Returns
    -------
    F_R, F_n : (3, 3) float64 each.
    """
    dx, dy = delta[0], delta[1]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    F_R = np.array([[1.0, 0.0, -s * dx - c * dy], [0.0, 1.0, c * dx - s * dy], [0.0, 0.0, 1.0]])
    F_n = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return F_R, F_n
