"""The plain NumPy form of the sensor: what one would write first, as the baseline of benchmarks.

The same model as `renderers.sensor` (same metering, so the same exposure), step by step on whole arrays:
``Generator.poisson`` and ``Generator.normal``, clip, gain, round, clip, white balance, sRGB by its formula.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderers.metering import Exposure, meter
from renderers.sensor import Sensor


@dataclass(frozen=True, eq=False)
class PlainRecording:
    """A picture with its ground truth, as `renderers.truth.Recording` has it."""

    image: NDArray[np.uint8]
    raw: NDArray[np.uint16]
    full: NDArray[np.uint8]
    diffuse: NDArray[np.uint8]
    highlight: NDArray[np.bool_]
    saturated: NDArray[np.bool_]


def record(
    sensor: Sensor,
    diffuse: NDArray[np.float32],
    luminance: NDArray[np.float32],
    white: NDArray[np.float64],
    rng: np.random.Generator,
    threshold: int = 16,
) -> PlainRecording:
    """Take a picture of ``luminance`` and note the truth about it.

    Parameters
    ----------
    diffuse, luminance : (H, W, 3) float32
        Without and with the specular light, cd/m² per channel.
    white : (3,) float64
        Linear sRGB of the light that becomes grey.
    """
    exposure = meter(sensor, luminance, white)
    per_luminance = sensor.electrons_per_luminance * exposure.seconds
    electrons, without = luminance * per_luminance, diffuse * per_luminance
    counted = rng.poisson(electrons) + rng.normal(0.0, sensor.read_noise_e, electrons.shape)
    raw = _digitise(sensor, counted)
    full = _develop(sensor, _digitise(sensor, electrons), exposure)
    target = _develop(sensor, _digitise(sensor, without), exposure)
    return PlainRecording(
        image=_develop(sensor, raw, exposure),
        raw=raw,
        full=full,
        diffuse=target,
        highlight=np.any(full.astype(int) - target >= threshold, axis=-1),
        saturated=np.any(electrons >= sensor.full_well_e, axis=-1),
    )


def _digitise(sensor: Sensor, electrons: NDArray[np.float64]) -> NDArray[np.uint16]:
    dn = np.minimum(electrons, sensor.full_well_e) * sensor.gain_dn_per_e + sensor.black_level_dn
    return np.clip(np.round(dn), 0, 2**sensor.bit_depth - 1).astype(np.uint16)


def _develop(sensor: Sensor, raw: NDArray[np.uint16], exposure: Exposure) -> NDArray[np.uint8]:
    black = sensor.black_level_dn
    linear = (raw.astype(float) - black) / (2**sensor.bit_depth - 1 - black) * exposure.white_balance
    linear = np.clip(linear, 0.0, 1.0)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * curve).astype(np.uint8)
