"""The calibration's distortion, as OpenCV has it, with its derivative and its inverse.

It acts on a plane p: of the tangents (X/Z, Y/Z) for a pinhole, of the angles θ (cos φ, sin φ) for a fisheye.
Every model here is p' = p g(|p|²) + t(p), g a ratio of polynomials, t a pinhole's tangential part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from vslam.errors import VslamError

FloatArray = NDArray[np.float64]

STAGES, NEWTON_STEPS = 8, 40
"""Of the way from the axis outwards, and of Newton's method at its end, where a few do."""


@dataclass(frozen=True)
class Distortion:
    """Coefficients of g's numerator and denominator beyond their leading 1, and (p1, p2) of t."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...] = ()
    tangential: tuple[float, float] = (0.0, 0.0)

    @staticmethod
    def of(model: str, coefficients: tuple[float, ...]) -> Distortion:
        """From OpenCV's list: (k1, k2, p1, p2[, k3[, k4, k5, k6]]) or, of a fisheye, (k1, k2, k3, k4).

        Raises
        ------
        VslamError
            For another number of coefficients, or one that is not finite.
        """
        counts = (0, 4) if model == "fisheye" else (0, 4, 5, 8)
        if len(coefficients) not in counts or not np.isfinite(coefficients).all():
            raise VslamError(
                f"calibration: a {model}'s distortion is {counts[1:]} finite numbers or none, "
                f"not {list(coefficients)}"
            )
        if model == "fisheye" or not coefficients:
            return Distortion(coefficients)
        k1, k2, p1, p2, *more = coefficients
        return Distortion((k1, k2, *more[:1]), tuple(more[1:]), (p1, p2))

    def __call__(self, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(n, 2) distorted points and (n, 2, 2) their derivative by the undistorted ones."""
        x, y = plane.T
        s = x * x + y * y
        top, bottom = Polynomial([1.0, *self.numerator]), Polynomial([1.0, *self.denominator])
        g = top(s) / bottom(s)
        dg = (top.deriv()(s) - g * bottom.deriv()(s)) / bottom(s)
        p1, p2 = self.tangential
        t = np.stack([2 * p1 * x * y + p2 * (s + 2 * x * x), p1 * (s + 2 * y * y) + 2 * p2 * x * y], axis=1)
        cross = 2 * dg * x * y + 2 * (p1 * x + p2 * y)
        derivative = [
            [g + 2 * dg * x * x + 2 * p1 * y + 6 * p2 * x, cross],
            [cross, g + 2 * dg * y * y + 6 * p1 * y + 2 * p2 * x],
        ]
        return g[:, None] * plane + t, np.moveaxis(np.array(derivative), -1, 0)

    def inverse(self, distorted: FloatArray) -> FloatArray:
        """(n, 2) undistorted points of (n, 2) distorted ones; NaN where there are none.

        Each is followed out from the axis, where nothing is distorted, so that no fold is crossed unseen.
        """
        if not any((*self.numerator, *self.denominator, *self.tangential)):
            return distorted
        plane, whole = np.zeros_like(distorted), np.ones(len(distorted), dtype=bool)
        with np.errstate(all="ignore"):
            for share in np.linspace(0.0, 1.0, STAGES + 1)[1:]:
                for _ in range(NEWTON_STEPS if share == 1.0 else 2):
                    step, turns = self._newton(plane, share * distorted)
                    plane, whole = plane + step, whole & ~turns
                    if np.nanmax(np.abs(step[whole]), initial=0.0) < 1e-14:
                        break
            left = np.abs(self(plane)[0] - distorted).max(axis=1)
            whole &= left < 1e-10 * (1.0 + np.abs(distorted).max(axis=1))
        return np.where(whole[:, None], plane, np.nan)

    def _newton(self, plane: FloatArray, wanted: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """A step towards what is distorted to ``wanted``, and where the map has turned over."""
        reached, d = self(plane)
        (x, y), determinant = (wanted - reached).T, d[:, 0, 0] * d[:, 1, 1] - d[:, 0, 1] * d[:, 1, 0]
        step = np.stack([d[:, 1, 1] * x - d[:, 0, 1] * y, d[:, 0, 0] * y - d[:, 1, 0] * x], axis=1)
        return step / determinant[:, None], ~((determinant > 0.0) & (d[:, 0, 0] > 0.0))
