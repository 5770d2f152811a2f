"""Diffuse light by iterative logarithmic differentiation (Tan & Ikeuchi 2005, "Separating reflection
components of textured surfaces using a single image", IEEE TPAMI 27).

The specular-free picture gives every pixel the same, arbitrary maximum chromaticity (by eq. 3-5, the paper's
specular-to-diffuse mechanism). Where all pixels are diffuse and of one colour, the logarithms of the picture
and of the specular-free picture have the same derivative; a difference tells of a highlight. There the
pixel of the smaller maximum chromaticity is given its neighbour's larger one, until no difference remains.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.filters.stages.specular_to_diffuse import GREY, specular_part

# ε falls from START to 0 by STEP (the authors' code); COLOUR is the change of both red and green chromaticity
# that marks the border of a surface (the paper's section 4.2; the authors' code)
START, STEP, COLOUR = 0.5, 0.01, 0.1
NOISE = 0.01
"""Maximum chromaticities this close count as equal (the authors' code; the paper compares exact numbers)."""
DARK = 10 / 255  # in no channel reached: too dark to have a colour; the authors' code

_FORM = "Array(float32, 3, 'C', readonly=True)"


def diffuse_by_differentiation(linear: NDArray[np.float32], noise: float = NOISE) -> NDArray[np.float32]:
    """Separate the diffuse part.

    The sum of the specular-free colour is in proportion to 3 max_c I_c − Σ_c I_c, so the difference of the
    two derivatives, Δ = dlog Σ_c I_c − dlog Σ_c I°_c (the paper's eqs. 16 … 18), is −dlog(3 σ − 1): the
    picture is compared through its maximum chromaticity σ alone and no logarithm is taken twice. For each
    ε, pairs of neighbours with |Δ| > ε are repaired in raster order, pass after pass as long as their
    number falls.

    Too dark and grey pixels, whose 3 σ − 1 is nought, take no part. One of the public ports takes the
    logarithm of the derivative, which is a different thing.

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear light, white-balanced.
    noise : float
        Differences of σ up to this count as none.

    Returns
    -------
    (H, W, 3) float32
        0 … ``linear``.
    """
    diffuse: NDArray[np.float32] = _iterate(np.ascontiguousarray(linear), noise)
    return diffuse


@njit(
    "boolean(float32[:, :, ::1], float32[:, ::1], float32[:, ::1], int64, int64, int64, int64, float64)",
    cache=True,
)
def _lift(image, sigma, log_excess, row, column, next_row, next_column, noise):  # type: ignore[no-untyped-def]
    """Give the pixel of smaller σ its neighbour's, unless a surface ends between them or both are equal."""
    here, there = image[row, column], image[next_row, next_column]
    total_here, total_there = here.sum(), there.sum()
    red = abs(here[0] / total_here - there[0] / total_there)
    green = abs(here[1] / total_here - there[1] / total_there)
    if red > COLOUR and green > COLOUR:
        return False
    difference = sigma[next_row, next_column] - sigma[row, column]
    if abs(difference) <= noise:
        return False
    if difference < 0.0:
        row, column, next_row, next_column = next_row, next_column, row, column
    pixel = image[row, column]
    specular = specular_part(pixel[0], pixel[1], pixel[2], sigma[next_row, next_column])
    for c in range(3):
        pixel[c] -= specular
    sigma[row, column] = sigma[next_row, next_column]
    log_excess[row, column] = log_excess[next_row, next_column]
    return True


@njit(f"float32[:, :, ::1]({_FORM}, float64)", cache=True)
def _iterate(linear, noise):  # type: ignore[no-untyped-def]
    height, width = linear.shape[:2]
    image = linear.copy()
    sigma = np.zeros((height, width), dtype=np.float32)
    log_excess = np.full((height, width), np.nan, dtype=np.float32)  # log(3 σ − 1); NaN takes no part
    for row in range(height):
        for column in range(width):
            red, green, blue = linear[row, column, 0], linear[row, column, 1], linear[row, column, 2]
            if max(red, green, blue) < DARK:
                continue
            sigma[row, column] = max(red, green, blue) / (red + green + blue)
            if sigma[row, column] > GREY:
                log_excess[row, column] = np.log(np.float32(3.0) * sigma[row, column] - np.float32(1.0))
    for level in range(int(START / STEP) + 1):
        epsilon = np.float32(START - level * STEP)
        lifted_before = height * width * 2
        while True:
            lifted = 0
            for row in range(height):
                for column in range(width):
                    here = log_excess[row, column]
                    if column + 1 < width and abs(log_excess[row, column + 1] - here) > epsilon:
                        lifted += _lift(image, sigma, log_excess, row, column, row, column + 1, noise)
                        here = log_excess[row, column]
                    if row + 1 < height and abs(log_excess[row + 1, column] - here) > epsilon:
                        lifted += _lift(image, sigma, log_excess, row, column, row + 1, column, noise)
            if lifted == 0 or lifted >= lifted_before:
                break
            lifted_before = lifted
    return image
