"""The three functions of SLAM through sigma points: a motion, a measurement, the founding of landmarks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts import many_poses
from vslam.backends.parts.sigma_points import (
    RuleOf,
    factor,
    offsets,
    regression,
    transform,
)
from vslam.frame import Odometry
from vslam.motion import move
from vslam.observation import ObservationModel

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Regression:
    """A function of the sub-state as its best linear fit: mean, matrix, and a root of what the fit leaves.

    Attributes
    ----------
    mean : (d,) float64
        The function's mean; of a measurement, its difference to the value at the estimate.
    matrix : (d, n) float64
        F, H or G.
    residual : (d, m) float64
        Its product with its transpose is the covariance beyond ``matrix`` P ``matrix``ᵀ, noise of a motion or
        of founding included, noise of a measurement not.
    """

    mean: FloatArray
    matrix: FloatArray
    residual: FloatArray


def motion(pose: FloatArray, A: FloatArray, odometry: Odometry, rule_of: RuleOf) -> Regression:
    """f(R, u, n) over pose and noise, six dimensions; A is a root of P_RR, (3, 3)."""
    rule = rule_of(6)
    points = offsets(6, rule)
    poses = pose[:, None] + A @ points[:, :3].T
    moved = move(poses, odometry.delta[:, None] + factor(odometry.covariance) @ points[:, 3:].T)
    moments = transform((moved - moved[:, :1]).T, rule)
    slopes = moments.slopes[:, :3]
    return Regression(moved[:, 0] + moments.offset, regression(slopes, A), moments.residual(slopes, rule))


def measurement(
    model: ObservationModel, state: FloatArray, A: FloatArray, rule_of: RuleOf
) -> tuple[FloatArray, Regression]:
    """H over pose and k landmarks, ``state`` (3 + 2k,); returns h at the estimate, (k, 2), and the fit."""
    rule = rule_of(len(state))
    points = state + offsets(len(state), rule) @ A.T
    z = many_poses.measure(model, points[:, :3], points[:, 3:].reshape(len(points), -1, 2))
    difference = model.innovation(z, z[:1])  # an angle's differences, not the angle, have a mean
    moments = transform(difference.reshape(len(points), -1), rule)
    fit = Regression(moments.offset, regression(moments.slopes, A), moments.residual(moments.slopes, rule))
    return z[0], fit


def founding(
    model: ObservationModel, pose: FloatArray, A: FloatArray, z: FloatArray, S: FloatArray, rule_of: RuleOf
) -> Regression:
    """G over pose and the noise of k measurements, 3 + 2k dimensions; A is a root of P_RR."""
    k = len(z)
    rule = rule_of(3 + 2 * k)
    points = offsets(3 + 2 * k, rule)
    poses = pose + points[:, :3] @ A.T
    noise = np.einsum("kij,mkj->mki", np.linalg.cholesky(S), points[:, 3:].reshape(-1, k, 2))
    landmarks = many_poses.place(model, poses, z + noise).reshape(len(points), -1)
    moments = transform(landmarks - landmarks[:1], rule)
    slopes = moments.slopes[:, :3]
    return Regression(landmarks[0] + moments.offset, regression(slopes, A), moments.residual(slopes, rule))
