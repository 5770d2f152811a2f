"""How a lens bends straight lines: OpenCV's two models, their inverse, and where they fold.

Both distort a plane. A pinhole's is the picture at z = 1, p = (X/Z, Y/Z); a fisheye's holds the angle to the
optical axis, p = θ (cos φ, sin φ). With s = |p|²,

    p' = p (1 + a₁ s + a₂ s² + …) / (1 + b₁ s + …) + t,
    t = (2 p₁ x y + p₂ (s + 2 x²), p₁ (s + 2 y²) + 2 p₂ x y)

Where |p'| no longer grows with |p|, two directions share one place: the model folds and means nothing beyond.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from renderers.errors import RendererError

FloatArray = NDArray[np.float64]

STEPS, SMALL = 40, 1e-13
"""Newton's steps at most, and the relative step that ends them; a few do."""

NODES = 1025
"""Of the radial table that Newton starts from."""


NEGLIGIBLE = 1e-12
"""Leading coefficients so small bend nothing within 89° by a millionth of a pixel, and break root finding."""


@dataclass(frozen=True)
class Distortion:
    """One of OpenCV's models by its coefficients.

    Attributes
    ----------
    radial, denominator : tuple of float
        a₁, a₂ … and b₁, b₂ …
    tangential : (p₁, p₂)
    largest : float
        |p| that no direction exceeds: π for a fisheye.
    """

    radial: tuple[float, ...] = ()
    denominator: tuple[float, ...] = ()
    tangential: tuple[float, float] = (0.0, 0.0)
    largest: float = np.inf

    @staticmethod
    def pinhole(coefficients: tuple[float, ...]) -> Distortion:
        """(k1, k2, p1, p2[, k3[, k4, k5, k6]]) as ``cv2.projectPoints`` has them (Brown 1966); or none.

        Raises
        ------
        RendererError
            For another number of coefficients, or one that is not finite.
        """
        _check("pinhole", coefficients, (0, 4, 5, 8))
        k1, k2, p1, p2, *more = coefficients or (0.0,) * 4
        return Distortion((k1, k2, *more[:1]), tuple(more[1:]), (p1, p2))

    @staticmethod
    def fisheye(coefficients: tuple[float, ...]) -> Distortion:
        """(k1, k2, k3, k4) as ``cv2.fisheye`` has them (Kannala & Brandt 2006, eq. 6); or none.

        Raises
        ------
        RendererError
            For another number of coefficients, or one that is not finite.
        """
        _check("fisheye", coefficients, (0, 4))
        return Distortion(coefficients, largest=np.pi)

    @property
    def absent(self) -> bool:
        """Whether nothing is distorted."""
        return not any((*self.radial, *self.denominator, *self.tangential))

    def apply(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where points of the plane go.

        Parameters
        ----------
        points : (..., 2) float64

        Returns
        -------
        distorted : (..., 2) float64
        jacobian : (..., 3) float64
            ∂x'/∂x, ∂x'/∂y = ∂y'/∂x, ∂y'/∂y.
        """
        x, y = points[..., 0], points[..., 1]
        p1, p2 = self.tangential
        s = x * x + y * y
        above, below = _series(self.radial), _series(self.denominator)
        over = 1.0 / below(s)
        scale = above(s) * over
        slope = 2.0 * (above.deriv()(s) - scale * below.deriv()(s)) * over  # twice d(scale)/ds
        distorted = [
            x * scale + 2 * p1 * x * y + p2 * (s + 2 * x * x),
            y * scale + p1 * (s + 2 * y * y) + 2 * p2 * x * y,
        ]
        jacobian = [
            scale + slope * x * x + 2 * p1 * y + 6 * p2 * x,
            slope * x * y + 2 * p1 * x + 2 * p2 * y,
            scale + slope * y * y + 6 * p1 * y + 2 * p2 * x,
        ]
        return np.stack(distorted, axis=-1), np.stack(jacobian, axis=-1)

    def invert(self, distorted: FloatArray) -> FloatArray:
        """The points that go to (..., 2) given ones; NaN where none does before the model folds.

        Newton's method in the plane, from a table of the radial part alone.
        """
        if self.absent:
            return np.where(
                np.hypot(*np.moveaxis(distorted, -1, 0))[..., None] < self.largest, distorted, np.nan
            )
        end = self.fold
        points = distorted * self._start(distorted, end)[..., None]
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                reached, (xx, xy, yy) = self._at(points)
                left = distorted - reached
                step = (
                    np.stack(
                        [yy * left[..., 0] - xy * left[..., 1], xx * left[..., 1] - xy * left[..., 0]],
                        axis=-1,
                    )
                    / (xx * yy - xy * xy)[..., None]
                )
                points = points + step
                if np.nanmax(np.abs(step) / (1.0 + np.abs(points)), initial=0.0) < SMALL:
                    break
            reached, (xx, xy, yy) = self._at(points)
            missed = np.abs(distorted - reached).max(axis=-1) < 1e-10 * (1.0 + np.abs(distorted).max(axis=-1))
            good = missed & (xx * yy > xy * xy) & (xx > 0) & (np.hypot(points[..., 0], points[..., 1]) < end)
        return np.where(good[..., None], points, np.nan)

    def radius(self, undistorted: float) -> float:
        """|p'| of a point at distance |p| by the radial part; NaN beyond the fold."""
        if undistorted >= self.fold:
            return float("nan")
        s = undistorted**2
        return float(undistorted * _series(self.radial)(s) / _series(self.denominator)(s))

    @property
    def fold(self) -> float:
        """|p| at which the radial part first stops growing, or its denominator vanishes."""
        return _fold(self)

    def _at(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        reached, jacobian = self.apply(points)
        return reached, np.moveaxis(jacobian, -1, 0)

    def _start(self, distorted: FloatArray, end: float) -> FloatArray:
        """(...) |p| / |p'| by the radial part alone, interpolated between points even in angle."""
        at = np.hypot(distorted[..., 0], distorted[..., 1])
        p = np.tan(np.linspace(0.0, np.arctan(min(end, 5e3)), NODES))
        with np.errstate(all="ignore"):
            table = p * _series(self.radial)(p * p) / _series(self.denominator)(p * p)
        table = np.maximum.accumulate(np.nan_to_num(table, nan=0.0, posinf=1e12))
        return np.where(at > 1e-12, np.interp(at, table, p) / np.maximum(at, 1e-12), 1.0)


def _check(model: str, coefficients: tuple[float, ...], counts: tuple[int, ...]) -> None:
    if len(coefficients) not in counts or not np.isfinite(coefficients).all():
        allowed = ", ".join(map(str, counts[:-1])) + f" or {counts[-1]}"
        raise RendererError(
            f"camera: distortion of a {model} is {allowed} finite numbers in OpenCV's order, "
            f"not {list(coefficients)}"
        )


def _series(coefficients: tuple[float, ...]) -> Polynomial:
    return Polynomial([1.0, *coefficients])


@lru_cache(maxsize=64)
def _fold(distortion: Distortion) -> float:
    above, below = _series(distortion.radial), _series(distortion.denominator)
    s = Polynomial([0.0, 1.0])
    # d/dp of p A(p²) / B(p²), times B²
    growth = (above + 2 * s * above.deriv()) * below - 2 * s * above * below.deriv()
    roots = np.concatenate([growth.trim(NEGLIGIBLE).roots(), below.trim(NEGLIGIBLE).roots()])
    real = roots[np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots.real))].real
    return float(np.sqrt(min([*real[real > 0], distortion.largest**2])))
