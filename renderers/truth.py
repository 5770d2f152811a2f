"""The exact ground truth of a recorded picture, from the ideal signal through the same camera.

Ideal is without noise, dark current and fixed patterns; optics, exposure, full well, ADC and development are
the picture's own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.colour_filter_array import behind_filters
from renderers.develop import develop, look_up, tone_table
from renderers.gbuffer import F32
from renderers.metering import Exposure, meter
from renderers.sensor import Sensor, digitise, expose, mean_electrons


@dataclass(frozen=True, eq=False)
class Recording:
    """A picture as the camera recorded it, with what is true about it.

    Attributes
    ----------
    image : (H, W, 3) uint8
        The recorded picture, sRGB, with noise.
    raw : (H, W, 3) uint16; (H, W) of a mosaic
        Its digital numbers.
    full, diffuse : (H, W, 3) uint8
        The noise-free picture, and the same without the specular light: the restoration target.
    highlight : (H, W) bool
        Where ``full`` exceeds ``diffuse`` by at least the threshold in any channel.
    saturated : (H, W) bool
        Where full well or ADC clip the noise-free signal in any channel; behind a mosaic, in any that the
        pixel would have without it.
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
    exposure: Exposure | None = None,
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
    exposure : Exposure, optional
        Settings of a bracket (`renderers.metering.bracket`); the sensor's own metering without them.
    """
    luminance = diffuse + specular
    exposure = exposure or meter(sensor, luminance, white)
    sensor = sensor.amplified(exposure.gain_db)
    electrons = mean_electrons(sensor, luminance, exposure.seconds)
    if not sensor.separable:
        return _record_in_steps(sensor, diffuse, electrons, exposure, rng, threshold)
    raw = expose(sensor, electrons, rng, exposure.seconds)
    dark, ideal = sensor.dark_electrons(exposure.seconds), tone_table(sensor, exposure)
    full, without = np.empty(raw.shape, np.uint8), np.empty(raw.shape, np.uint8)
    highlight, saturated = np.empty(raw.shape[:2], np.bool_), np.empty(raw.shape[:2], np.bool_)
    _truth(
        electrons.reshape(-1, 3),
        diffuse.reshape(-1, 3),
        (sensor.electrons_per_luminance * exposure.seconds).astype(np.float32),
        sensor.saturation_e,
        sensor.gain_dn_per_e,
        sensor.black_level_dn,
        sensor.largest_dn,
        ideal,
        threshold,
        full.reshape(-1, 3),
        without.reshape(-1, 3),
        highlight.reshape(-1),
        saturated.reshape(-1),
    )
    image = look_up(tone_table(sensor, exposure, dark) if dark else ideal, raw)
    return Recording(image, raw, full, without, highlight, saturated, exposure)


def _record_in_steps(
    sensor: Sensor,
    diffuse: F32,
    electrons: F32,
    exposure: Exposure,
    rng: np.random.Generator,
    threshold: float,
) -> Recording:
    """Through mosaic and colour matrix, where a pixel's colour depends on more than its own numbers."""
    array = sensor.colour_filter_array

    def ideal(signal: F32) -> NDArray[np.uint8]:
        return develop(sensor, digitise(sensor, behind_filters(array, signal)), exposure)

    raw = expose(sensor, behind_filters(array, electrons), rng, exposure.seconds)
    image = develop(sensor, raw, exposure, sensor.dark_electrons(exposure.seconds))
    full, without = ideal(electrons), ideal(mean_electrons(sensor, diffuse, exposure.seconds))
    highlight = np.any(full.astype(np.int16) - without >= threshold, axis=-1)
    saturated = np.any(electrons >= sensor.saturation_e, axis=-1)
    return Recording(image, raw, full, without, highlight, saturated, exposure)


@njit(cache=True)
def _truth(
    electrons: F32,
    diffuse: F32,
    per_luminance: F32,
    full_well: float,
    gain: float,
    black: float,
    largest: float,
    table: NDArray[np.uint8],
    threshold: float,
    full: NDArray[np.uint8],
    without: NDArray[np.uint8],
    highlight: NDArray[np.bool_],
    saturated: NDArray[np.bool_],
) -> None:
    """`digitise` and `develop` with and without specular light, and their comparison, in one pass."""
    well, k, rounded, top = (
        np.float32(full_well),
        np.float32(gain),
        np.float32(black + 0.5),
        np.int32(largest),
    )
    for i in range(len(electrons)):
        lit, clipped = False, False
        for c in range(3):
            both, alone = electrons[i, c], diffuse[i, c] * per_luminance[c]
            clipped = clipped or bool(both >= well)
            dn_both = min(np.int32((both if both < well else well) * k + rounded), top)
            dn_alone = min(np.int32((alone if alone < well else well) * k + rounded), top)
            full[i, c], without[i, c] = table[dn_both, c], table[dn_alone, c]
            lit = lit or bool(np.int32(full[i, c]) - np.int32(without[i, c]) >= threshold)
        highlight[i], saturated[i] = lit, clipped
