"""The valley-emphasis threshold, eq. 3-3 (Ng 2006, "Automatic thresholding for defect detection")."""

from __future__ import annotations

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from vslam.filters.stages.srgb import READABLE_CODES

LEVELS = 256
NO_THRESHOLD = LEVELS - 1  # nothing lies above it


def grey_histogram(grey: NDArray[np.uint8]) -> NDArray[np.int64]:
    """How often each grey level occurs: (256,) int64 from an array of uint8."""
    return np.asarray(_count(np.ascontiguousarray(grey).reshape(-1)), dtype=np.int64)


@njit(types.int64[::1](READABLE_CODES), error_model="numpy", cache=True)
def _count(grey):  # type: ignore[no-untyped-def]
    # four tables: neighbours are often equal, and adding to the number just written would wait for it
    counts = np.zeros((4, LEVELS), dtype=np.int64)
    words = grey[: grey.size - grey.size % 8].view(np.uint64)
    byte, every_byte = np.uint64(0xFF), np.uint64(0x0101010101010101)
    for word in words:
        first = word & byte
        if word == first * every_byte:  # a minimum over patches stays the same over many neighbours
            counts[0, first] += 8
        else:
            for at in range(0, 64, 32):
                counts[0, (word >> np.uint64(at)) & byte] += 1
                counts[1, (word >> np.uint64(at + 8)) & byte] += 1
                counts[2, (word >> np.uint64(at + 16)) & byte] += 1
                counts[3, (word >> np.uint64(at + 24)) & byte] += 1
    for i in range(8 * words.size, grey.size):
        counts[0, grey[i]] += 1
    return counts[0] + counts[1] + counts[2] + counts[3]


def valley_emphasis(histogram: NDArray[np.int64]) -> int:
    """Find the threshold that separates two classes best and lies in a valley of the histogram.

    t* = argmax_t (1 − p(t)) · (ω1(t) μ1(t)² + ω2(t) μ2(t)²), where class 1 holds the levels up to and
    including t, class 2 those above it, so that ``level > t*`` (eq. 3-4) picks class 2. Of equal maxima
    the smallest t is taken.

    The equation has no meaning where a class is empty (its mean is 0/0), so such t are no candidates.
    Without any candidate (a constant picture, an empty histogram) nothing is separated: the answer is
    255, above which no level lies.

    Parameters
    ----------
    histogram : (256,) int64
        Counts of the grey levels 0…255.

    Returns
    -------
    int
        t*, 0…255.
    """
    return best_level(histogram, valley=True)


def best_level(histogram: NDArray[np.int64], valley: bool) -> int:
    """Find the first t with the largest ω1 μ1² + ω2 μ2², times 1 − p(t) with ``valley``; 255 without any."""
    return int(_best_level(np.ascontiguousarray(histogram, dtype=np.int64), valley))


@njit("int64(int64[::1], boolean)", error_model="numpy", cache=True)
def _best_level(histogram, valley):  # type: ignore[no-untyped-def]
    # sums of grey levels are integers below 2⁵³, hence exact as float64: equal criteria compare as equal
    total, sum_of_all = 0.0, 0.0
    for level in range(LEVELS):
        total += histogram[level]
        sum_of_all += histogram[level] * level
    best, largest, below, sum_below = NO_THRESHOLD, -1.0, 0.0, 0.0
    for level in range(LEVELS):
        below += histogram[level]
        sum_below += histogram[level] * level
        above, sum_above = total - below, sum_of_all - sum_below
        if below > 0.0 and above > 0.0:
            # ω μ² = (n/N) (s/n)² = s² / (n N)
            criterion = (sum_below * sum_below / below + sum_above * sum_above / above) / total
            if valley:
                criterion *= 1.0 - histogram[level] / total
            if criterion > largest:
                best, largest = level, criterion
    return best
