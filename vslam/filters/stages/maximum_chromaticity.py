"""Λmax of a whole picture: one number for eq. 3-5, read from the pixels that no highlight touches.

There the specular part is zero, so the observed chromaticity σ = max_c I_c / Σ_c I_c is the diffuse one.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.filters.stages.specular_to_diffuse import DARKEST
from vslam.filters.stages.srgb import DECODED

_BINS = 2048  # over 1/3…1: a step of 0.0003, far below GREY_MARGIN


def picture_chromaticity(
    image: NDArray[np.uint8],
    highlight_free: NDArray[np.bool_],
    quantile: float = 0.5,
    decoded: NDArray[np.float32] = DECODED,
) -> float:
    """Take a quantile of σ over the usable highlight-free pixels.

    Usable is a pixel whose brightest channel lies between ``DARKEST`` (below it quantisation and noise
    make up the colour) and 254 (at 255 it may be clipped, and its colour false).

    The default, the median, is the number nearest to all surfaces; the largest σ of a picture (quantile
    1) is that of its noisiest or most saturated pixel, and would darken all others.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB, C-contiguous.
    highlight_free : (H, W) bool
        The pixels that may serve.
    quantile : float
        0…1.
    decoded : (256,) float32
        The light that each code is taken for; sRGB's by default.

    Returns
    -------
    float
        Λmax, 1/3…1; NaN when no pixel is usable.
    """
    counts = _chromaticity_histogram(image, highlight_free, decoded, DARKEST)
    cumulative = np.cumsum(counts)
    if cumulative[-1] == 0:
        return float("nan")
    rank = min(int(quantile * cumulative[-1]), cumulative[-1] - 1)
    bin_of_rank = np.searchsorted(cumulative, rank, side="right")
    return float((1.0 + 2.0 * (bin_of_rank + 0.5) / _BINS) / 3.0)


@njit("int64[::1](uint8[:, :, ::1], boolean[:, ::1], float32[::1], int64)", cache=True)
def _chromaticity_histogram(image, highlight_free, decoded, darkest):  # type: ignore[no-untyped-def]
    counts = np.zeros(_BINS, dtype=np.int64)
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            if not highlight_free[row, column]:
                continue
            red, green, blue = image[row, column, 0], image[row, column, 1], image[row, column, 2]
            brightest = max(red, green, blue)
            if brightest < darkest or brightest == 255:
                continue
            sigma = decoded[brightest] / (decoded[red] + decoded[green] + decoded[blue])
            position = int((3.0 * sigma - 1.0) * (_BINS / 2))
            counts[min(max(position, 0), _BINS - 1)] += 1
    return counts
