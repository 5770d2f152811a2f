"""How far a camera's mount can be trusted: a robot that nods and rolls moves its floor points.

Turning the camera by a small angle δ about an axis a turns the ray d to a floor point P = c + d into
d + δ a × d, which meets the floor at P + δ J_a,  J_a = (a × d)_xy − d_xy (a × d)_z / d_z.  With d_z = −h, for
the robot's left axis (pitch) and forward axis (roll):

    J_pitch = −(h + d_x²/h, d_x d_y/h)        J_roll = (d_x d_y/h, h + d_y²/h)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.camera import Calibration

FloatArray = NDArray[np.float64]


def tilt_jacobian(calibration: Calibration, points: FloatArray) -> FloatArray:
    """Derivative of floor points by pitch (nose down is positive) and roll (to the right) of the camera.

    Parameters
    ----------
    points : (n, 2) float64
        Robot frame, metres.

    Returns
    -------
    (n, 2, 2) float64
        Metres per rad; columns are pitch and roll.
    """
    camera = calibration.T_robot_camera[:3, 3]
    height = float(camera[2])
    x, y = (points - camera[:2]).T
    rows = [-(height + x * x / height), x * y / height, -x * y / height, height + y * y / height]
    return np.stack(rows, axis=-1).reshape(-1, 2, 2)


def mount_covariances(
    calibration: Calibration, points: FloatArray, tilt_sigma_rad: float, position_sigma_m: float
) -> FloatArray:
    """What an imperfect mount adds to the covariance of floor points.

    Parameters
    ----------
    points : (n, 2) float64
        Robot frame, metres.
    tilt_sigma_rad : float
        Standard deviation of pitch and of roll from picture to picture, rad.
    position_sigma_m : float
        Of either coordinate of the floor point, whatever its distance, metres.

    Returns
    -------
    (n, 2, 2) float64
        m².
    """
    J = tilt_jacobian(calibration, points)
    return tilt_sigma_rad**2 * (J @ J.transpose(0, 2, 1)) + position_sigma_m**2 * np.eye(2)
