"""Specular to diffuse, eq. 3-5 (Tan & Ikeuchi 2005, "Separating reflection components")."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from vslam.filters.stages.srgb import READABLE_CODES, encode_value
from vslam.filters.stages.transfer import SRGB, Transfer

GREY_MARGIN = 0.01
"""How far Λmax must lie above 1/3 to count as a colour.

One sRGB level in one channel of a grey pixel shifts its Λmax by 0.01 at level 40 and by less above. So
0.01 is what an 8-bit picture can tell from grey; it also keeps the noise gain 1/(3 Λmax − 1) of eq. 3-5
below 34.
"""
DARKEST = 40
"""sRGB level of the brightest channel below which one level of noise moves Λmax by more than that."""

GREY = 1.0 / 3.0 + GREY_MARGIN
"""The largest Λmax that still counts as grey."""


def specular_to_diffuse(linear: NDArray[Any], lambda_max: float | NDArray[Any]) -> NDArray[Any]:
    """Remove the specular part of each pixel, given the maximum chromaticity of its diffuse part.

    I_D = I − (max_c I_c − Λmax Σ_c I_c) / (1 − 3 Λmax); what is subtracted is clipped to 0 … min_c I_c,
    because neither part of eq. 3-1 can be negative, so 0 ≤ I_D ≤ I. Where Λmax is grey (no more than 1/3
    + ``GREY_MARGIN``: the singularity) or NaN (unknown) the equation says nothing and the pixel stays as
    it is.

    Parameters
    ----------
    linear : (N, 3) float32 or float64
        Linear light, white-balanced by the illuminant Γ.
    lambda_max : float or (N,) floats
        Λmax = max_c Λ_c of each pixel's diffuse colour, 1/3…1.

    Returns
    -------
    (N, 3), of the type of ``linear``
        The diffuse part m_d Λ.
    """
    per_pixel = np.empty(len(linear), dtype=linear.dtype)
    per_pixel[:] = lambda_max
    diffuse: NDArray[Any] = _specular_to_diffuse(np.ascontiguousarray(linear), per_pixel)
    return diffuse


def repair_masked(
    image: NDArray[np.uint8],
    mask: NDArray[np.bool_],
    lambda_max: float | NDArray[np.float32],
    transfer: Transfer = SRGB,
) -> NDArray[np.uint8]:
    """Eq. 3-5 on the masked pixels of a recorded picture; every other pixel keeps its codes.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB, C-contiguous.
    mask : (H, W) bool
        What to repair.
    lambda_max : float or (H, W) float32
        One for the picture, or one for each pixel, read inside the mask only.
    transfer : Transfer
        What light the codes are taken for.

    Returns
    -------
    (H, W, 3) uint8
        A new array.
    """
    repaired = image.copy()
    # flat arrays: of several indices the compiler does not see that none is negative, and checks each
    codes, where, result = image.reshape(-1), mask.reshape(-1), repaired.reshape(-1)
    tables = transfer.decoded, transfer.code_at_bin, transfer.next_in_bin
    if isinstance(lambda_max, np.ndarray):
        _repair_by_map(codes, where, lambda_max.reshape(-1), *tables, result)
    elif lambda_max > GREY:
        _repair_by_one(codes, where, lambda_max, 1.0 / (3.0 * lambda_max - 1.0), *tables, result)
    return repaired


@njit(inline="always")
def specular_part(red, green, blue, lambda_max):  # type: ignore[no-untyped-def]
    """Find what eq. 3-5 subtracts from each channel of one pixel."""
    if not lambda_max > GREY:
        return 0.0
    # two by two: numba compiles three at once to worse code
    smallest, largest = min(red, min(green, blue)), max(red, max(green, blue))
    specular = (largest - lambda_max * (red + green + blue)) / (1.0 - 3.0 * lambda_max)
    return min(max(specular, 0.0), smallest)


@njit(
    ["float32[:, ::1](float32[:, ::1], float32[::1])", "float64[:, ::1](float64[:, ::1], float64[::1])"],
    cache=True,
)
def _specular_to_diffuse(linear, lambda_max):  # type: ignore[no-untyped-def]
    diffuse = linear.copy()
    for i in range(linear.shape[0]):
        diffuse[i] -= specular_part(linear[i, 0], linear[i, 1], linear[i, 2], lambda_max[i])
    return diffuse


_TABLES = (types.float32[::1], types.uint8[::1], types.float32[::1])


@njit(
    types.void(READABLE_CODES, types.boolean[::1], types.float32[::1], *_TABLES, types.uint8[::1]),
    error_model="numpy",
    cache=True,
)
def _repair_by_map(codes, mask, lambda_max, decoded, code_at_bin, next_in_bin, repaired):  # type: ignore[no-untyped-def]
    """Decode, eq. 3-5, encode, pixel by pixel; what it leaves unchanged keeps its codes to the bit."""
    for pixel in range(mask.size):
        if mask[pixel]:
            at = 3 * pixel
            red, green, blue = decoded[codes[at]], decoded[codes[at + 1]], decoded[codes[at + 2]]
            specular = np.float32(specular_part(red, green, blue, lambda_max[pixel]))
            if specular > 0.0:
                repaired[at] = encode_value(red - specular, code_at_bin, next_in_bin)
                repaired[at + 1] = encode_value(green - specular, code_at_bin, next_in_bin)
                repaired[at + 2] = encode_value(blue - specular, code_at_bin, next_in_bin)


@njit(inline="always")
def _repair_pixel(codes, at, lambda_max, gain, decoded, code_at_bin, next_in_bin, repaired):  # type: ignore[no-untyped-def]
    red, green, blue = decoded[codes[at]], decoded[codes[at + 1]], decoded[codes[at + 2]]
    smallest, largest = min(red, min(green, blue)), max(red, max(green, blue))
    specular = min((lambda_max * (red + green + blue) - largest) * gain, smallest)
    # no branch: encoding what was decoded gives the code back, and whether it is zero is hard to foresee
    specular = max(specular, np.float32(0.0))
    repaired[at] = encode_value(red - specular, code_at_bin, next_in_bin)
    repaired[at + 1] = encode_value(green - specular, code_at_bin, next_in_bin)
    repaired[at + 2] = encode_value(blue - specular, code_at_bin, next_in_bin)


@njit(
    types.void(READABLE_CODES, types.boolean[::1], types.float32, types.float32, *_TABLES, types.uint8[::1]),
    error_model="numpy",
    cache=True,
)
def _repair_by_one(codes, mask, lambda_max, gain, decoded, code_at_bin, next_in_bin, repaired):  # type: ignore[no-untyped-def]
    """Do the same with one Λmax: the division by 1 − 3 Λmax becomes one factor, and all stays in float32."""
    in_eights = mask[: mask.size - mask.size % 8].view(np.uint64)
    for eight in range(in_eights.size):
        if in_eights[eight] != 0:
            for pixel in range(8 * eight, 8 * eight + 8):
                if mask[pixel]:
                    _repair_pixel(
                        codes, 3 * pixel, lambda_max, gain, decoded, code_at_bin, next_in_bin, repaired
                    )
    for pixel in range(8 * in_eights.size, mask.size):
        if mask[pixel]:
            _repair_pixel(codes, 3 * pixel, lambda_max, gain, decoded, code_at_bin, next_in_bin, repaired)
