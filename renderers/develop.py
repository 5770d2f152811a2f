"""From raw digital numbers to the sRGB picture: black level, white balance, clip, demosaicing, colour matrix,
sRGB encoding.

White balance comes before demosaicing, so that grey is flat across the mosaic, and clips at white there, so
that what was clipped in one channel stays without colour; below black the noise keeps its sign up to the
encoding.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.colour_filter_array import NO_ARRAY, sites
from renderers.colour_matrix import correction
from renderers.demosaicing import demosaic
from renderers.gbuffer import F32
from renderers.metering import Exposure
from renderers.sensor import Sensor

CODES = 2**16
"""Entries of the encoding's table: twenty to the finest step of 8-bit sRGB."""


def develop(
    sensor: Sensor, raw: NDArray[np.uint16], exposure: Exposure, dark_electrons: float = 0.0
) -> NDArray[np.uint8]:
    """Raw numbers to an sRGB picture, IEC 61966-2-1.

    Parameters
    ----------
    sensor : Sensor
        At the gain that ``raw`` was taken with (`Sensor.amplified`).
    raw : (H, W, 3) uint16; (H, W) of a mosaic
    dark_electrons : float
        Mean of the dark current, which the camera reads from its covered pixels and takes for black.

    Returns
    -------
    (H, W, 3) uint8
    """
    if sensor.separable:
        return look_up(tone_table(sensor, exposure, dark_electrons), raw)
    balanced = _balanced(sensor, raw, exposure, dark_electrons)
    if sensor.colour_filter_array != NO_ARRAY:
        balanced = demosaic(sensor.demosaicing, balanced, sensor.colour_filter_array)
    picture = np.empty(balanced.shape, dtype=np.uint8)
    matrix = correction(sensor.sensitivities).astype(np.float32)
    _correct(balanced.reshape(-1, 3), matrix, _codes(), picture.reshape(-1, 3))
    return picture


def tone_table(sensor: Sensor, exposure: Exposure, dark_electrons: float = 0.0) -> NDArray[np.uint8]:
    """(2^bits, 3) uint8: the sRGB value of each raw number in each channel; the largest number is white."""
    return encode(_linear_table(sensor, exposure, dark_electrons))


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


def _linear_table(sensor: Sensor, exposure: Exposure, dark_electrons: float) -> NDArray[np.float64]:
    """(2^bits, 3): white-balanced light of each raw number, 1 = white."""
    black = sensor.black_level_dn + sensor.gain_dn_per_e * min(dark_electrons, 0.9 * sensor.saturation_e)
    linear = (np.arange(sensor.largest_dn + 1) - black) / (sensor.largest_dn - black)
    return np.outer(linear, exposure.white_balance)


def _balanced(sensor: Sensor, raw: NDArray[np.uint16], exposure: Exposure, dark_electrons: float) -> F32:
    """The shape of ``raw``, float32: white-balanced light, at most 1."""
    table = np.minimum(_linear_table(sensor, exposure, dark_electrons), 1.0).astype(np.float32)
    balanced = np.empty(raw.shape, np.float32)
    if raw.ndim == 3:
        for channel in range(3):
            balanced[..., channel] = table[:, channel][raw[..., channel]]
    else:
        for where, channel in sites(sensor.colour_filter_array):
            balanced[where] = table[:, channel][raw[where]]
    return balanced


@cache
def _codes() -> NDArray[np.uint8]:
    """(CODES,) uint8: sRGB of evenly spaced linear light, 0…1."""
    return encode(np.linspace(0.0, 1.0, CODES))


@njit(cache=True)
def _correct(planes: F32, matrix: F32, codes: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
    """White clips again before the matrix: demosaicing overshoots at edges, and that must not gain colour."""
    zero, one, half, steps = np.float32(0), np.float32(1), np.float32(0.5), np.float32(len(codes) - 1)
    for i in range(len(planes)):
        r, g, b = min(planes[i, 0], one), min(planes[i, 1], one), min(planes[i, 2], one)
        for c in range(3):
            light = matrix[c, 0] * r + matrix[c, 1] * g + matrix[c, 2] * b
            out[i, c] = codes[np.int32(min(max(light, zero), one) * steps + half)]


@njit(cache=True)
def _look_up(table: NDArray[np.uint8], raw: NDArray[np.uint16], out: NDArray[np.uint8]) -> None:
    """Four times as fast as NumPy's indexing."""
    for i in range(len(raw)):
        for c in range(3):
            out[i, c] = table[raw[i, c], c]
