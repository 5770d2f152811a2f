"""The lens, on linear light before the sensor: vignetting, blur, and the light that scatters in it.

All of it is linear in the light, so diffuse and specular pass through it apart and still add up to the whole,
and a light basis may pass once per pose instead of every picture under every illumination.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import erf, erfc, sqrt
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from renderers.basis import LightBasis
from renderers.camera import Camera, Pinhole, pixel_grid
from renderers.errors import RendererError
from renderers.gbuffer import F32

VIGNETTINGS = ("none", "natural")

KERNEL, COARSE_SIGMA = (5, 5), 0.8
"""Of the Gaussian on each level of the pyramid, in that level's pixels."""

SMALLEST = 3
"""Rows or columns that the coarsest level keeps at least."""


@dataclass(frozen=True)
class Optics:
    """What a lens does to light, beside its projection.

    Attributes
    ----------
    vignetting : str
        ``natural``: the falloff of the projection itself, cos⁴ θ for a pinhole camera, sin θ / θ for an
        equidistant fisheye, and what distortion makes of it (`falloff`); ``none``.
    blur_px : float
        Standard deviation of the image of a point, from focus and diffraction, pixels.
    glare : float
        Share of the light that scatters in lens and body. Of a clean lens 0.01–0.03, of a cheap or dusty one
        up to 0.1, as veiling glare indices (ISO 9358) go.
    glare_radius_px : float
        r₀ of the scattered light's profile (1 + r²/r₀²)^−3/2, whose half lies within √3 r₀: near a lamp a
        bloom, far from it a veil that falls with r⁻³.
    """

    vignetting: str = "none"
    blur_px: float = 0.0
    glare: float = 0.0
    glare_radius_px: float = 4.0

    def __post_init__(self) -> None:
        if self.vignetting not in VIGNETTINGS:
            raise RendererError(
                f"optics: unknown vignetting {self.vignetting!r}; use {', '.join(VIGNETTINGS)}"
            )
        if not (np.isfinite(self.blur_px) and 0 <= self.blur_px <= 50):
            raise RendererError(f"optics: blur_px must lie in 0…50, not {self.blur_px}")
        if not 0 <= self.glare < 1:
            raise RendererError(f"optics: glare must be a share in 0…1, not {self.glare}")
        if not (np.isfinite(self.glare_radius_px) and self.glare_radius_px > 0):
            raise RendererError(f"optics: glare_radius_px must be positive, not {self.glare_radius_px}")

    @property
    def ideal(self) -> bool:
        """Whether light passes unchanged."""
        return self.vignetting == "none" and self.blur_px == 0 and self.glare == 0


def through_lens(optics: Optics, camera: Camera, light: F32) -> F32:
    """The image that the lens makes of (H, W, 3) float32 linear light; linear in it.

    Parameters
    ----------
    camera : Camera
        Of the size of ``light``.
    """
    seen: Any = light
    if optics.vignetting == "natural":
        seen = cv2.multiply(seen, falloff(camera))
    if optics.blur_px > 0:
        seen = cv2.GaussianBlur(seen, (0, 0), optics.blur_px, borderType=cv2.BORDER_REFLECT)
    if optics.glare > 0:
        scattered = scatter(seen, optics.glare_radius_px)
        seen = cv2.addWeighted(seen, 1 - optics.glare, scattered, optics.glare, 0.0)
    return np.asarray(seen, dtype=np.float32)


def basis_through_lens(optics: Optics, camera: Camera, basis: LightBasis) -> LightBasis:
    """A light basis whose every layer went through the lens: each picture relit from it has, too."""
    if optics.ideal:
        return basis
    diffuse, specular = (
        np.stack([through_lens(optics, camera, layer) for layer in layers])
        for layers in (basis.diffuse, basis.specular)
    )
    return replace(basis, diffuse=diffuse, specular=specular)


@lru_cache(maxsize=4)
def falloff(camera: Camera) -> F32:
    """(H, W, 3) float32: illuminance on the image plane by constant luminance, 1 on the axis.

    A pixel gets light in proportion to the solid angle it sees, and a flat entrance pupil shrinks with cos θ;
    the two make a pinhole's cos⁴ θ. A fisheye's pupil turns towards the light, so the solid angle alone is
    left: sin θ / θ where r = f θ. Distortion changes the solid angle, not the pupil.
    """
    pixels = pixel_grid(camera)
    step = np.array([0.5, 0.0])
    across = camera.unproject(pixels + step) - camera.unproject(pixels - step)
    down = camera.unproject(pixels + step[::-1]) - camera.unproject(pixels - step[::-1])
    seen = np.linalg.norm(np.cross(across, down), axis=-1)
    if isinstance(camera, Pinhole):
        seen *= camera.unproject(pixels)[..., 2]
    seen *= camera.intrinsics.fx * camera.intrinsics.fy  # on the axis distortion vanishes
    share = np.repeat(seen.astype(np.float32)[..., None], 3, axis=-1)
    share.setflags(write=False)
    return share


def scatter(light: F32, radius: float) -> F32:
    """Light spread by the profile (1 + r²/r₀²)^−3/2 of unit energy.

    The profile is a mixture of Gaussians with σ = r₀ / |Z|, Z standard normal; one Gaussian per octave of σ
    from a pyramid stands for the mixture (within a fifth, ring by ring). The surroundings of the picture are
    its mirror image, so an even picture stays even and no light is lost; halving odd sides costs up to 0.5 %
    of it near an edge. What would spread further than the coarsest level becomes an even veil.
    """
    levels = max(1, int(np.log2(min(light.shape[:2]) / SMALLEST)) + 1)
    shares, veil = _octaves(radius, levels)
    pyramid: list[Any] = [light]
    for _ in range(levels - 1):
        half = [(side + 1) // 2 for side in pyramid[-1].shape[1::-1]]
        pyramid.append(cv2.resize(pyramid[-1], half, interpolation=cv2.INTER_AREA))
    even = pyramid[-1].mean(axis=(0, 1), dtype=np.float64)
    total: Any = np.broadcast_to((veil * even).astype(np.float32), pyramid[-1].shape)
    for level, share in zip(pyramid[::-1], shares[::-1], strict=True):
        if level.shape != total.shape:
            total = cv2.resize(total, level.shape[1::-1], interpolation=cv2.INTER_LINEAR)
        spread = cv2.GaussianBlur(level, KERNEL, COARSE_SIGMA, borderType=cv2.BORDER_REFLECT)
        total = cv2.scaleAdd(spread, float(share), total)
    return np.asarray(total, dtype=np.float32)


def level_sigma(level: int) -> float:
    """Standard deviation in pixels of what a level of the pyramid makes of a point.

    Averaging blocks of 2ᵏ, the Gaussian, and interpolating back add (4ᵏ − 1)/12, 4ᵏ σ² and (4ᵏ − 1)/4.
    """
    return sqrt((4**level - 1) / 3 + 4**level * COARSE_SIGMA**2)


def _octaves(radius: float, levels: int) -> tuple[NDArray[np.float64], float]:
    """The mixture's share of each level, and what is left for the veil."""
    edges = [0.0, *(sqrt(level_sigma(k) * level_sigma(k + 1)) for k in range(levels))]
    below = np.array([0.0, *(erfc(radius / (edge * sqrt(2))) for edge in edges[1:])])
    return np.diff(below), erf(radius / (edges[-1] * sqrt(2)))
