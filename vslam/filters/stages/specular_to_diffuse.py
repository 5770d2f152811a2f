"""Specular to diffuse, eq. 3-5 (Tan & Ikeuchi 2005, "Separating reflection components")."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.filters.stages.srgb import encode_value
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
    lambda_max: NDArray[np.float32],
    transfer: Transfer = SRGB,
) -> NDArray[np.uint8]:
    """Eq. 3-5 on the masked pixels of a recorded picture; every other pixel keeps its codes.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB, C-contiguous.
    mask : (H, W) bool
        What to repair.
    lambda_max : (H, W) float32
        Read inside the mask only.
    transfer : Transfer
        What light the codes are taken for.

    Returns
    -------
    (H, W, 3) uint8
        A new array.
    """
    tables = transfer.decoded, transfer.code_at_bin, transfer.boundaries
    repaired: NDArray[np.uint8] = _repair_masked(image, mask, lambda_max, *tables)
    return repaired


@njit(
    ["float32(float32, float32, float32, float32)", "float64(float64, float64, float64, float64)"], cache=True
)
def specular_part(red, green, blue, lambda_max):  # type: ignore[no-untyped-def]
    """Find what eq. 3-5 subtracts from each channel of one pixel."""
    if not lambda_max > GREY:
        return 0.0
    smallest, largest = min(red, green, blue), max(red, green, blue)
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


@njit(
    "uint8[:, :, ::1](uint8[:, :, ::1], boolean[:, ::1], float32[:, ::1],"
    " float32[::1], uint8[::1], float64[::1])",
    cache=True,
)
def _repair_masked(image, mask, lambda_max, decoded, code_at_bin, boundaries):  # type: ignore[no-untyped-def]
    """Decode, eq. 3-5, encode, pixel by pixel; what it leaves unchanged keeps its codes to the bit."""
    repaired = image.copy()
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            if not mask[row, column]:
                continue
            codes = image[row, column]
            red, green, blue = decoded[codes[0]], decoded[codes[1]], decoded[codes[2]]
            specular = specular_part(red, green, blue, lambda_max[row, column])
            if specular > 0.0:
                repaired[row, column, 0] = encode_value(red - specular, code_at_bin, boundaries)
                repaired[row, column, 1] = encode_value(green - specular, code_at_bin, boundaries)
                repaired[row, column, 2] = encode_value(blue - specular, code_at_bin, boundaries)
    return repaired
