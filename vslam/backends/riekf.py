"""EKF-SLAM with the right-invariant error.

Sources: Barrau & Bonnabel 2015, "An EKF-SLAM algorithm with consistency properties" (arXiv 1510.06263),
algorithm 1; Zhang, Wu, Song, Huang & Dissanayake 2017, "Convergence and consistency analysis for a 3-D
invariant-EKF SLAM".

The state is an element of SE_{1+n}(2) and its error ξ is taken in the world's axes: with J the quarter turn,

    θ − θ̂ = ξ_θ,   p − p̂ = ξ_p + ξ_θ J p̂,   L_i − L̂_i = ξ_i + ξ_θ J L̂_i,

or e = T(X̂) ξ, where only the heading's column of T differs from the identity. A turn of the whole map is
then ξ_θ alone, whatever the estimate, so no linearisation can make it observable.

Written in e, which `FullCovariance` holds, the filter is `Ekf` but for its correction: prediction, gain and
founding are the same (T leaves the landmarks' rows as they are while the robot moves, and T⁻¹ K and H T
belong together). The correction differs twice: the step ξ = T⁻¹ K Z is applied through the exponential map,
and P moves along with the estimate, P ← M P Mᵀ with M = T(X̂⁺) T(X̂)⁻¹ = I + m e_θᵀ, m = J (X̂⁺ − X̂) per point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyr2

from vslam.backends.ekf import Ekf
from vslam.geometry import rotation
from vslam.slam_backend import backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_HEADING = 2


@backends.register("riekf")
class RightInvariantEkf(Ekf):
    """The right-invariant extended Kalman filter."""

    name = "riekf"
    nearest = 0  # a correction turns the whole of P, so an area larger than what is seen has no use

    def _apply(self, numbers: IntArray, H: FloatArray, R: FloatArray, Z: FloatArray) -> None:
        super()._apply(numbers, H, R, Z)
        self._activate(numbers)  # the area's P was turned, too; what was just seen will mostly be seen again

    def _shift(self, step: FloatArray) -> None:
        correction = np.zeros(len(self._X))
        others = self._area.shift_of_others()
        correction[: len(others)] = others
        correction[self._area.rows] = step
        self._retract(correction)

    def _retract(self, correction: FloatArray) -> None:
        """X ← exp(T⁻¹ K Z) X, and P with it."""
        angle, points = correction[_HEADING], self._points(self._X)
        step = self._points(correction) - angle * _quarter_turn(points)  # ξ = T⁻¹ K Z
        moved = points @ rotation(angle).T + step @ _left_jacobian(angle).T
        m = np.zeros(len(self._X))
        m[: self._size] = self._vector(_quarter_turn(moved - points), 0.0)
        self._X[: self._size] = self._vector(moved, self._X[_HEADING] + angle)
        self._turn_covariance(m)

    def _turn_covariance(self, m: FloatArray) -> None:
        """M P Mᵀ = P + m qᵀ + q mᵀ with q = P e_θ + ½ P_θθ m; the active area must be entered anew."""
        p = np.zeros(len(m))
        p[: self._size] = self._area.columns(3)[:, _HEADING]
        self._settle()
        q = p + 0.5 * p[_HEADING] * m
        self._P = dsyr2(1.0, m, q, lower=1, a=self._P, overwrite_a=1)

    def _points(self, state: FloatArray) -> FloatArray:
        """Robot and landmarks as points, (1 + n, 2)."""
        return np.vstack([state[:2], state[3 : self._size].reshape(-1, 2)])

    def _vector(self, points: FloatArray, heading: float) -> FloatArray:
        return np.concatenate([points[0], [heading], points[1:].ravel()])


def _quarter_turn(points: FloatArray) -> FloatArray:
    return np.column_stack([-points[:, 1], points[:, 0]])


def _left_jacobian(angle: float) -> FloatArray:
    """V(φ) = ∫₀¹ Rot(sφ) ds, the translation's part of the exponential map of SE(2)."""
    if abs(angle) < 1e-8:
        return np.array([[1.0, -0.5 * angle], [0.5 * angle, 1.0]])
    s, c = np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle
    return np.array([[s, -c], [c, s]])
