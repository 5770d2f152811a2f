"""Λmax of a whole picture: one number for eq. 3-5, read from the pixels that no highlight touches.

There the specular part is zero, so the observed chromaticity σ = max_c I_c / Σ_c I_c is the diffuse one.
"""

from __future__ import annotations

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from vslam.filters.stages.specular_to_diffuse import DARKEST
from vslam.filters.stages.srgb import DECODED, READABLE_CODES

_BINS = 2048  # over 1/3…1: a step of 0.0003, far below GREY_MARGIN


def picture_chromaticity(
    image: NDArray[np.uint8],
    highlight_free: NDArray[np.bool_],
    quantile: float = 0.5,
    decoded: NDArray[np.float32] = DECODED,
    every: int = 1,
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
    every : int
        Only every so many rows serve. A quantile between the extremes is known well enough from a part of
        the pixels (a median of 10,000 to 1/80 of their spread); the largest σ is not.

    Returns
    -------
    float
        Λmax, 1/3…1; NaN when no pixel is usable.
    """
    width, flat = image.shape[1], (image.reshape(-1), highlight_free.reshape(-1))
    counts = _chromaticity_histogram(*flat, decoded, DARKEST, width, every)
    cumulative = np.cumsum(counts)
    if cumulative[-1] == 0:
        return float("nan")
    rank = min(int(quantile * cumulative[-1]), cumulative[-1] - 1)
    bin_of_rank = np.searchsorted(cumulative, rank, side="right")
    return float((1.0 + 2.0 * (bin_of_rank + 0.5) / _BINS) / 3.0)


@njit(
    types.int64[::1](
        READABLE_CODES, types.boolean[::1], types.float32[::1], types.int64, types.int64, types.int64
    ),
    error_model="numpy",
    cache=True,
)
def _chromaticity_histogram(codes, highlight_free, decoded, darkest, width, every):  # type: ignore[no-untyped-def]
    counts = np.zeros(_BINS + 1, dtype=np.int64)
    # σ ≥ 1/3 up to rounding, and what rounding leaves below zero is cut off to bin 0
    slope, offset = np.float32(3 * _BINS / 2), np.float32(_BINS / 2)
    for start in range(0, highlight_free.size, width * every):
        for pixel in range(start, start + width):
            if not highlight_free[pixel]:
                continue
            red, green, blue = codes[3 * pixel], codes[3 * pixel + 1], codes[3 * pixel + 2]
            brightest = max(red, max(green, blue))  # two by two: numba compiles three at once to worse code
            if brightest < darkest or brightest == 255:
                continue
            sigma = decoded[brightest] / (decoded[red] + decoded[green] + decoded[blue])
            counts[np.uint32(slope * sigma - offset)] += 1
    counts[_BINS - 1] += counts[_BINS]  # σ = 1
    return counts[:_BINS]
