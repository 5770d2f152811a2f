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
    highlight_free : (⌈H / every⌉, W) bool
        The pixels that may serve, of the rows that serve.
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
    bin_of_rank = _bin_of_rank(counts, quantile)
    return float((1.0 + 2.0 * (bin_of_rank + 0.5) / _BINS) / 3.0) if bin_of_rank >= 0 else float("nan")


@njit("int64(int64[::1], float64)", cache=True)
def _bin_of_rank(counts, quantile):  # type: ignore[no-untyped-def]
    """Find the bin that holds a quantile of what was counted; −1 where nothing was."""
    total = counts.sum()
    rank, upto = min(int(quantile * total), total - 1), 0
    for k in range(counts.size):
        upto += counts[k]
        if upto > rank >= 0:
            return k
    return -1


@njit(error_model="numpy")
def _find_usable(codes, highlight_free, darkest, usable):  # type: ignore[no-untyped-def]
    for x in range(usable.size):
        red, green, blue = codes[3 * x], codes[3 * x + 1], codes[3 * x + 2]
        of_two = red if red > green else green  # so written, it is compiled to vector instructions
        brightest = of_two if of_two > blue else blue
        usable[x] = highlight_free[x] & (brightest >= darkest) & (brightest < np.uint8(255))


@njit(
    types.int64[::1](
        READABLE_CODES, types.boolean[::1], types.float32[::1], types.uint8, types.int64, types.int64
    ),
    error_model="numpy",
    cache=True,
)
def _chromaticity_histogram(codes, highlight_free, decoded, darkest, width, every):  # type: ignore[no-untyped-def]
    counts = np.zeros(_BINS + 1, dtype=np.int64)
    usable = np.zeros(width + 7, dtype=np.bool_)
    in_eights = usable[: (width + 7) // 8 * 8].view(np.uint64)
    # σ ≥ 1/3 up to rounding, and what rounding leaves below zero is cut off to bin 0
    slope, offset = np.float32(3 * _BINS / 2), np.float32(_BINS / 2)
    for start in range(0, highlight_free.size, width):
        row = codes[3 * start * every : 3 * (start * every + width)]
        _find_usable(row, highlight_free[start : start + width], darkest, usable[:width])
        for eight in range(in_eights.size):
            if in_eights[eight] == 0:
                continue
            for x in range(8 * eight, 8 * eight + 8):
                if usable[x]:
                    red, green, blue = decoded[row[3 * x]], decoded[row[3 * x + 1]], decoded[row[3 * x + 2]]
                    # two by two: numba compiles three at once to worse code
                    sigma = max(red, max(green, blue)) / (red + green + blue)
                    counts[np.uint32(slope * sigma - offset)] += 1
    counts[_BINS - 1] += counts[_BINS]  # σ = 1
    return counts[:_BINS]
