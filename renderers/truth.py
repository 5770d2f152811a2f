"""The exact ground truth of a recorded picture, from the noise-free signal through the same camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderers.gbuffer import F32
from renderers.sensor import Exposure, Sensor, develop, digitise, expose, mean_electrons, meter


@dataclass(frozen=True, eq=False)
class Recording:
    """A picture as the camera recorded it, with what is true about it.

    Attributes
    ----------
    image : (H, W, 3) uint8
        The recorded picture, sRGB, with noise.
    raw : (H, W, 3) uint16
        Its digital numbers.
    full, diffuse : (H, W, 3) uint8
        The noise-free picture, and the same without the specular light: the restoration target.
    highlight : (H, W) bool
        Where ``full`` exceeds ``diffuse`` by at least the threshold in any channel.
    saturated : (H, W) bool
        Where full well or ADC clip the noise-free signal in any channel.
    exposure : Exposure
    """

    image: NDArray[np.uint8]
    raw: NDArray[np.uint16]
    full: NDArray[np.uint8]
    diffuse: NDArray[np.uint8]
    highlight: NDArray[np.bool_]
    saturated: NDArray[np.bool_]
    exposure: Exposure

    @property
    def light(self) -> NDArray[np.bool_]:
        """(H, W) bool: highlight or saturated, the pixels affected by light."""
        return self.highlight | self.saturated


def record(
    sensor: Sensor,
    diffuse: F32,
    specular: F32,
    white: NDArray[np.float64],
    rng: np.random.Generator,
    threshold: float = 16,
) -> Recording:
    """Take a picture of diffuse plus specular luminance and note the truth about it.

    Parameters
    ----------
    diffuse, specular : (H, W, 3) float32
        Luminance per channel, cd/m² (`renderers.basis.relight`).
    white : (3,) float64
        Linear sRGB of the light that the white balance renders grey.
    threshold : float
        τ, the least difference in grey levels of 255 that counts as highlight.
    """
    luminance = diffuse + specular
    exposure = meter(sensor, luminance, white)
    electrons = mean_electrons(sensor, luminance, exposure)
    raw = expose(sensor, electrons, rng)
    full = develop(sensor, digitise(sensor, electrons), exposure)
    without = develop(sensor, digitise(sensor, mean_electrons(sensor, diffuse, exposure)), exposure)
    return Recording(
        image=develop(sensor, raw, exposure),
        raw=raw,
        full=full,
        diffuse=without,
        highlight=_any_channel(full.astype(np.int16) - without >= threshold),
        saturated=_any_channel(electrons >= sensor.full_well_e),
        exposure=exposure,
    )


def _any_channel(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H, W) from (H, W, 3); NumPy reduces an axis of three ten times slower."""
    return flags[..., 0] | flags[..., 1] | flags[..., 2]
