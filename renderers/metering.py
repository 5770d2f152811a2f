"""Automatic exposure and white balance, one frame at a time: how a camera sets itself for a picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from renderers.colour_matrix import to_camera
from renderers.errors import RendererError
from renderers.gbuffer import F32
from renderers.sensor import Sensor

EVERY = 4
"""Every fourth pixel in both directions is metered."""

CENTRE_SHARE = 0.75
"""Of the weight that centre-weighted metering gives to a disc half as wide as the picture is high, as the
75 : 25 meters of film cameras did with their 12 mm disc."""

CLIPPED_SHARE = 0.01
"""Of the pixels that highlight-priority metering lets clip."""


@dataclass(frozen=True, eq=False)
class Exposure:
    """The settings that one picture is taken with.

    Attributes
    ----------
    seconds : float
    white_balance : (3,) float64
        Factor on each channel, the smallest 1, so that a clipped pixel stays white.
    gain_db : float
        Analogue gain.
    """

    seconds: float
    white_balance: NDArray[np.float64]
    gain_db: float = 0.0


def meter(sensor: Sensor, luminance: F32, white: NDArray[np.float64]) -> Exposure:
    """Choose exposure time, gain and white balance for a scene's luminance.

    The time comes first; where the shutter's longest is too short, gain makes up for it up to the sensor's
    ``max_gain_db``. All three channels count alike, behind a mosaic too.

    ``average``: the mean over pixels and channels, each clipped where the ADC is full, is the target.
    ``centre-weighted``: the same with `CENTRE_SHARE` of the weight in the middle.
    ``highlight-priority``: the longest time at which at most `CLIPPED_SHARE` of the pixels clip.
    The white balance makes light of the colour ``white`` grey.

    Parameters
    ----------
    luminance : (H, W, 3) float32, cd/m² per channel
    white : (3,) float64
        Linear sRGB of the light to be rendered white.
    """
    response = sensor.electrons_per_luminance / sensor.saturation_e
    balance = 1.0 / (response * np.maximum(to_camera(sensor.sensitivities, white), 1e-6))
    balance /= balance.min()
    if sensor.exposure_s is not None:
        return Exposure(sensor.exposure_s, balance, sensor.gain_db)
    seen = to_camera(sensor.sensitivities, luminance[::EVERY, ::EVERY])
    fill_rate = (seen * response.astype(np.float32)).astype(np.float64)
    if sensor.metering == "highlight-priority":
        seconds = _until_clipped(fill_rate)
    else:
        height, width, _ = fill_rate.shape
        weights = _weights(height, width, sensor.metering == "centre-weighted")
        seconds = _until_mean(fill_rate, sensor.metering_target, weights)
    shutter = float(np.clip(seconds, sensor.min_exposure_s, sensor.max_exposure_s))
    return Exposure(shutter, balance, sensor.gain_db + _more_gain(sensor, seconds / shutter))


def shifted(sensor: Sensor, exposure: Exposure, stops: float) -> Exposure:
    """One picture of a bracket: so many stops more (+) or less (−), by time, within the shutter's limits.

    An exposure time that is set by hand counts as within them.

    Raises
    ------
    RendererError
        If the number of stops is not finite.
    """
    if not np.isfinite(stops):
        raise RendererError(f"bracketing: stops must be a finite number, not {stops}")
    low, high = min(sensor.min_exposure_s, exposure.seconds), max(sensor.max_exposure_s, exposure.seconds)
    return replace(exposure, seconds=float(np.clip(exposure.seconds * 2.0**stops, low, high)))


def _more_gain(sensor: Sensor, lacking: float) -> float:
    """Decibels on top of the sensor's own, for a factor of light that the shutter does not give."""
    most = max(sensor.max_gain_db - sensor.gain_db, 0.0)
    return float(np.clip(20 * np.log10(max(lacking, 1.0)), 0.0, most))


def _until_mean(fill_rate: NDArray[np.float64], target: float, weights: NDArray[np.float64]) -> float:
    """Seconds at which the weighted mean of min(rate t, 1) is the target; infinite if it never is.

    Newton's steps from 0 rise to the solution and end on it: the mean is concave, piecewise linear in t.
    Sums are NumPy's own, as BLAS adds in an order that depends on its threads.
    """
    channels = fill_rate.shape[-1]
    rate, share = fill_rate.reshape(-1), np.repeat(weights.reshape(-1) / channels, channels)
    weighted, seconds = share * rate, 0.0
    while True:
        rising = rate * seconds < 1
        slope = (weighted * rising).sum()
        if slope == 0:
            return np.inf
        better = float((target - (share * ~rising).sum()) / slope)
        if better <= seconds * (1 + 1e-12):
            return seconds
        seconds = better


def _until_clipped(fill_rate: NDArray[np.float64]) -> float:
    brightest = fill_rate.max(axis=-1).reshape(-1)
    rate = np.quantile(brightest, 1 - CLIPPED_SHARE)
    return float(1.0 / rate) if rate > 0 else np.inf


def _weights(height: int, width: int, centred: bool) -> NDArray[np.float64]:
    """(H, W) weight of each metered pixel, 1 in sum."""
    uniform = np.full((height, width), 1.0 / (height * width))
    if not centred:
        return uniform
    v, u = np.ogrid[0:height, 0:width]
    disc = np.hypot(u - (width - 1) / 2, v - (height - 1) / 2) <= max(height / 4, 1.0)
    return np.asarray(CENTRE_SHARE * disc / disc.sum() + (1 - CENTRE_SHARE) * ~disc / max((~disc).sum(), 1))
