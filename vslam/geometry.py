"""Plane geometry that every part of the room shares: angles, rotations and the two frames (eqs. 3-6, 3-7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def wrap_angle(angle: ArrayLike) -> FloatArray:
    """Bring angles into [−π, π).

    Parameters
    ----------
    angle : array_like of float, any shape, rad

    Returns
    -------
    float64 array of the same shape, rad.
    """
    return np.asarray((np.asarray(angle, dtype=np.float64) + np.pi) % (2.0 * np.pi) - np.pi)


def rotation(theta: float) -> FloatArray:
    """Rot(θ), (2, 2) float64: turns a vector counter-clockwise by ``theta`` rad."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s], [s, c]])


def to_local(pose: FloatArray, points: FloatArray) -> FloatArray:
    """World points in the robot's frame, L_local = Rot(θ)ᵀ (L_global − R_trans) (eq. 3-6).

    Parameters
    ----------
    pose : (3,) float64
        x, y (metres) and heading (rad).
    points : (n, 2) float64, metres, world

    Returns
    -------
    (n, 2) float64, metres: forward and left.
    """
    # Row vectors: (Rotᵀ v)ᵀ = vᵀ Rot.
    return (points - pose[:2]) @ rotation(pose[2])


def to_global(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Points of the robot's frame in the world, L_global = Rot(θ) L_local + R_trans (eq. 3-7).

    Parameters
    ----------
    pose : (3,) float64
        x, y (metres) and heading (rad).
    points : (n, 2) float64, metres, forward and left

    Returns
    -------
    (n, 2) float64, metres, world.
    """
    return points @ rotation(pose[2]).T + pose[:2]
