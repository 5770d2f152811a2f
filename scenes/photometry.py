"""How a lamp spreads its light: intensity over direction, per lumen that the lamp emits."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError

FloatArray = NDArray[np.float64]

SPOT_STEPS = 64
"""Samples across a spot's soft edge: its parabola is then followed to 1e-4."""


@dataclass(frozen=True, eq=False, repr=False)
class Photometry:
    """A type C web: angles about the lamp's axis, intensity bilinear between them.

    Attributes
    ----------
    vertical : (v,) float64
        Ascending angles from the axis, degrees, 0…180. Beyond the first and last there is no light.
    horizontal : (h,) float64
        Ascending half-planes, degrees: 0…360, or a single 0 for light even about the axis.
    candela_per_lumen : (h, v) float64
        Integrates to 1 lm over the sphere.
    lumen : float
        Flux of the luminaire that was measured; 1 where nothing was.
    """

    vertical: FloatArray
    horizontal: FloatArray
    candela_per_lumen: FloatArray
    lumen: float = 1.0

    def __repr__(self) -> str:  # caches tell lamps apart by it
        digest = hashlib.blake2b(digest_size=8)
        for array in (self.vertical, self.horizontal, self.candela_per_lumen):
            digest.update(array.tobytes())
        return f"Photometry({digest.hexdigest()})"

    @staticmethod
    def of(vertical: FloatArray, horizontal: FloatArray, candela: FloatArray) -> Photometry:
        """Normalise a measured web to one lumen, and keep its flux.

        Raises
        ------
        SceneError
            If an intensity is negative or not finite, or there is no light at all.
        """
        if not (np.isfinite(candela).all() and (candela >= 0).all()):
            raise SceneError("photometry: an intensity is negative or not finite")
        lumen = flux(vertical, horizontal, candela)
        if lumen <= 0:
            raise SceneError("photometry: the lamp gives no light in any direction")
        return Photometry(vertical, horizontal, candela / lumen, lumen)

    @staticmethod
    def spot(inner_deg: float, outer_deg: float) -> Photometry:
        """A cone: full intensity within ``inner_deg`` of the axis, none beyond ``outer_deg`` (half angles).

        Between them the square of a line in the angle's cosine, as glTF's KHR_lights_punctual has it.
        """
        if not 0.0 <= inner_deg < outer_deg <= 180.0:
            raise SceneError(f"spot: needs 0 ≤ inner < outer ≤ 180 degrees, not {inner_deg} and {outer_deg}")
        edge = np.linspace(inner_deg, outer_deg, SPOT_STEPS)
        vertical = np.unique(np.concatenate([[0.0], edge]))
        inner, outer = np.cos(np.radians([inner_deg, outer_deg]))
        share = np.clip((np.cos(np.radians(vertical)) - outer) / (inner - outer), 0.0, 1.0)
        web = Photometry.of(vertical, np.zeros(1), share[None] ** 2)
        return Photometry(web.vertical, web.horizontal, web.candela_per_lumen)


def flux(vertical: FloatArray, horizontal: FloatArray, candela: FloatArray) -> float:
    """Lumen of a web: ∫∫ I sin θ dθ dφ, exact for intensities that are bilinear in angle."""
    theta = np.radians(vertical)
    if len(theta) == 1:
        return float(4 * np.pi * candela[0, 0])
    a, b = theta[:-1], theta[1:]
    slope = np.diff(candela, axis=1) / (b - a)
    level = candela[:, :-1] - slope * a
    rings = -(level + slope * b) * np.cos(b) + slope * np.sin(b)
    rings += (level + slope * a) * np.cos(a) - slope * np.sin(a)
    planes = rings.sum(axis=1)
    if len(horizontal) == 1:
        return float(2 * np.pi * planes[0])
    return float(np.trapezoid(planes, np.radians(horizontal)))


ISOTROPIC = Photometry(np.zeros(1), np.zeros(1), np.full((1, 1), 1 / (4 * np.pi)))
"""The same intensity everywhere: 1/4π candela per lumen."""
