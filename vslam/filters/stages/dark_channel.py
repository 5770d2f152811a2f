"""The dark channel, eq. 3-2 (He, Sun & Tang 2009, "Single image haze removal using dark channel prior")."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.stages.srgb import READABLE_CODES

PATCH = 15  # pixels; He et al. 2009, section 3


def dark_channel(image: NDArray[np.uint8], patch: int = PATCH) -> NDArray[np.uint8]:
    """Find the smallest value of any channel in a square patch around each pixel.

    Parameters
    ----------
    image : (H, W, 3) uint8
        The recorded picture.
    patch : int
        Side of Ω(x), pixels, odd. Where the patch hangs over the border, the pixels inside count.

    Returns
    -------
    (H, W) uint8
        I_dark(x) = min_{y ∈ Ω(x)} min_{c ∈ {r,g,b}} I_c(y).

    Raises
    ------
    VslamError
        When ``patch`` is not a positive odd number.
    """
    check_patch(patch)
    smallest = _smallest_channel(np.ascontiguousarray(image).reshape(-1)).reshape(image.shape[:2])
    # erosion is the minimum over the patch; OpenCV's default border is +∞, which no minimum ever picks
    return np.asarray(cv2.erode(smallest, square(patch)), dtype=np.uint8)


@njit(types.uint8[::1](READABLE_CODES), error_model="numpy", cache=True)
def _smallest_channel(codes):  # type: ignore[no-untyped-def]
    smallest = np.empty(codes.size // 3, dtype=np.uint8)
    for pixel in range(smallest.size):
        red, green, blue = codes[3 * pixel], codes[3 * pixel + 1], codes[3 * pixel + 2]
        of_two = red if red < green else green  # so written, it is compiled to vector instructions
        smallest[pixel] = of_two if of_two < blue else blue
    return smallest


def square(side: int) -> NDArray[np.uint8]:
    """Build the structuring element Ω: (side, side) uint8 of ones."""
    return np.ones((side, side), dtype=np.uint8)


def check_patch(patch: int) -> None:
    """Refuse a patch that has no centre.

    Raises
    ------
    VslamError
        When ``patch`` is not a positive odd number.
    """
    if not isinstance(patch, int) or isinstance(patch, bool) or patch < 1 or patch % 2 == 0:
        raise VslamError(f"dark channel: patch {patch} has no centre pixel; give a positive odd number")
