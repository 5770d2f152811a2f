"""From raw digital numbers to the sRGB picture: black level, white balance, clip, encoding."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.metering import Exposure
from renderers.sensor import Sensor


def develop(
    sensor: Sensor, raw: NDArray[np.uint16], exposure: Exposure, dark_electrons: float = 0.0
) -> NDArray[np.uint8]:
    """Raw numbers to an sRGB picture: black level, white balance, clip, IEC 61966-2-1 encoding.

    Parameters
    ----------
    raw : (H, W, 3) uint16
    dark_electrons : float
        Mean of the dark current, which the camera reads from its covered pixels and takes for black.
    """
    return look_up(tone_table(sensor, exposure, dark_electrons), raw)


def tone_table(sensor: Sensor, exposure: Exposure, dark_electrons: float = 0.0) -> NDArray[np.uint8]:
    """(2^bits, 3) uint8: the sRGB value of each raw number in each channel; the largest number is white."""
    black = sensor.black_level_dn + sensor.gain_dn_per_e * min(dark_electrons, 0.9 * sensor.full_well_e)
    linear = (np.arange(sensor.largest_dn + 1) - black) / (sensor.largest_dn - black)
    return encode(np.outer(linear, exposure.white_balance))


def look_up(table: NDArray[np.uint8], raw: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """(H, W, 3) uint8: each channel's number by its own column of a `tone_table`."""
    picture = np.empty(raw.shape, dtype=np.uint8)
    _look_up(table, raw.reshape(-1, 3), picture.reshape(-1, 3))
    return picture


def encode(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Linear light, clipped to 0…1, to 8-bit sRGB (IEC 61966-2-1)."""
    light = np.clip(linear, 0.0, 1.0)
    curve = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255 * curve).astype(np.uint8)


@njit(cache=True)
def _look_up(table: NDArray[np.uint8], raw: NDArray[np.uint16], out: NDArray[np.uint8]) -> None:
    """Four times as fast as NumPy's indexing."""
    for i in range(len(raw)):
        for c in range(3):
            out[i, c] = table[raw[i, c], c]
