"""The exact ground truth of a recorded picture, from the ideal signal through the same camera.

Ideal is without noise, dark current and fixed patterns; optics, exposure, full well, ADC and development are
the picture's own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.colour_filter_array import behind_filters
from renderers.develop import develop, look_up, tone_table
from renderers.gbuffer import F32
from renderers.metering import Exposure, meter
from renderers.sensor import Sensor, digitise, expose, mean_electrons, per_row


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
        Settings of a bracket (`renderers.metering.shifted`); the sensor's own metering without them.
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
        _rows(electrons),
        _rows(diffuse),
        per_row(sensor.electrons_per_luminance * exposure.seconds, raw.shape[1]),
        sensor.saturation_e,
        sensor.gain_dn_per_e,
        sensor.black_level_dn,
        sensor.largest_dn,
        ideal,
        threshold,
        _rows(full),
        _rows(without),
        highlight,
        saturated,
    )
    image = look_up(tone_table(sensor, exposure, dark) if dark else ideal, raw)
    return Recording(image, raw, full, without, highlight, saturated, exposure)


def _rows(picture: NDArray[Any]) -> NDArray[Any]:
    """(H, W·3): a picture's rows with the channels side by side."""
    return picture.reshape(len(picture), -1)


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
    """`digitise` and `develop` with and without specular light, and their comparison.

    Row by row, each step in a loop of its own: all but the look-up then run on many values at once.
    """
    well, k, rounded, top = (
        np.float32(full_well),
        np.float32(gain),
        np.float32(black + 0.5),
        np.int32(largest),
    )
    height, values = electrons.shape
    both, alone = np.empty(values, np.uint32), np.empty(values, np.uint32)
    lit, clipped = np.empty(values, np.bool_), np.empty(values, np.bool_)
    for r in range(height):
        for j in range(values):
            e, d = electrons[r, j], diffuse[r, j] * per_luminance[j]
            clipped[j] = e >= well
            both[j] = np.uint32(min(np.int32((e if e < well else well) * k + rounded), top))
            alone[j] = np.uint32(min(np.int32((d if d < well else well) * k + rounded), top))
        for i in range(values // 3):
            for c in range(3):
                full[r, 3 * i + c] = table[both[3 * i + c], c]
                without[r, 3 * i + c] = table[alone[3 * i + c], c]
        for j in range(values):
            lit[j] = np.int32(full[r, j]) - np.int32(without[r, j]) >= threshold
        for i in range(values // 3):
            highlight[r, i] = lit[3 * i] | lit[3 * i + 1] | lit[3 * i + 2]
            saturated[r, i] = clipped[3 * i] | clipped[3 * i + 1] | clipped[3 * i + 2]
