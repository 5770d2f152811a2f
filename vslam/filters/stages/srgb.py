"""The sRGB transfer function (IEC 61966-2-1), exact in both directions: by table for 8 bits, else by formula.

Eq. 3-5 adds light, so it holds for linear values only; pictures are recorded encoded.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numba import njit, types
from numpy.typing import NDArray

READABLE_CODES = types.Array(types.uint8, 1, "C", readonly=True)
"""The compiled type of codes that a kernel only reads: an array may be read-only or not."""

_CODES = np.arange(256)
# No bin may hold two code boundaries: the narrowest code is 1/(255 · 12.92) = 1/3295 wide in linear light
_BINS = 4096


def decode_exactly(encoded: NDArray[Any]) -> NDArray[np.float64]:
    """Linear light 0…1 of encoded values 0…1, by the formula; any shape."""
    encoded = np.asarray(encoded, dtype=np.float64)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def encode_exactly(linear: NDArray[Any]) -> NDArray[np.float64]:
    """Encoded values 0…1 of linear light 0…1, by the formula; any shape."""
    linear = np.asarray(linear, dtype=np.float64)
    # the two branches of the standard meet here to within 10⁻⁸, so that decoding gives the same value back
    return np.where(linear <= 0.04045 / 12.92, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


DECODED = decode_exactly(_CODES / 255.0).astype(np.float32)
"""(256,) float32: the linear value of each code, 0…1."""


def encoding_tables(boundaries: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """What ``encode_value`` looks up.

    Parameters
    ----------
    boundaries : (257,) float64
        Light at which each code begins: −∞ first, +∞ last.

    Returns
    -------
    code_at_bin : (4097,) uint8
        The code at the lower end of each bin of light.
    next_in_bin : (4097,) float32
        Where the code after that one begins, rounded up: a float32 is as large if and only if it is as
        large as the boundary.
    """
    code_at_bin = np.searchsorted(boundaries, np.arange(_BINS + 1) / _BINS, side="right") - 1
    begins = boundaries[code_at_bin + 1]
    nearest = begins.astype(np.float32)
    rounded_up = np.where(nearest < begins, np.nextafter(nearest, np.float32(np.inf)), nearest)
    return code_at_bin.astype(np.uint8), rounded_up


# Code k is the nearest to linear values between boundary k and boundary k + 1
BOUNDARIES = np.concatenate([[-np.inf], decode_exactly((_CODES[1:] - 0.5) / 255.0), [np.inf]])
CODE_AT_BIN, NEXT_IN_BIN = encoding_tables(BOUNDARIES)


def decode(encoded: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Linear light 0…1, float32, of sRGB codes; any shape."""
    flat = np.ascontiguousarray(encoded).reshape(1, -1)
    return np.asarray(cv2.LUT(flat, DECODED), dtype=np.float32).reshape(encoded.shape)


def encode(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Round linear light to the nearest sRGB code; any shape, clipped to 0…1, NaN gives 0."""
    flat = np.ascontiguousarray(linear, dtype=np.float32).reshape(-1)
    return _encode(flat, CODE_AT_BIN, NEXT_IN_BIN).reshape(linear.shape)


@njit(inline="always")
def encode_value(linear, code_at_bin, next_in_bin):  # type: ignore[no-untyped-def]
    """Encode a float32 in 0…1: a table finds the code or the one below it; one comparison decides.

    After a change here, delete the caches of the kernels that call it: numba compares their own files only.
    """
    position = np.uint32(linear * np.float32(_BINS))
    return np.uint8(code_at_bin[position] + (linear >= next_in_bin[position]))


@njit("uint8[::1](float32[::1], uint8[::1], float32[::1])", cache=True)
def _encode(linear, code_at_bin, next_in_bin):  # type: ignore[no-untyped-def]
    codes = np.empty(linear.size, dtype=np.uint8)
    for i in range(linear.size):
        if linear[i] > 0.0:  # NaN is not
            codes[i] = encode_value(min(linear[i], np.float32(1.0)), code_at_bin, next_in_bin)
        else:
            codes[i] = 0
    return codes
