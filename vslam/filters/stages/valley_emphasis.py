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
    whole = grey.size - grey.size % 4
    for i in range(0, whole, 4):
        counts[0, grey[i]] += 1
        counts[1, grey[i + 1]] += 1
        counts[2, grey[i + 2]] += 1
        counts[3, grey[i + 3]] += 1
    for i in range(whole, grey.size):
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
    counts = histogram.astype(np.float64)
    return best_level((1.0 - counts / max(counts.sum(), 1.0)) * class_spread(counts))


def class_spread(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Find ω1(t) μ1(t)² + ω2(t) μ2(t)² at each level t: (256,) float64, NaN where a class is empty."""
    below = np.cumsum(counts)
    above = below[-1] - below
    separates = (below > 0) & (above > 0)
    # sums of grey levels are integers below 2⁵³, hence exact: equal criteria compare as equal
    sum_below = np.cumsum(counts * np.arange(LEVELS))
    sum_above = sum_below[-1] - sum_below
    # ω μ² = (n/N) (s/n)² = s² / (n N)
    spread = (sum_below**2 / np.maximum(below, 1) + sum_above**2 / np.maximum(above, 1)) / max(below[-1], 1.0)
    return np.where(separates, spread, np.nan)


def best_level(criterion: NDArray[np.float64]) -> int:
    """Pick the level of the largest criterion, the first of equals; 255 where every one is NaN."""
    return NO_THRESHOLD if np.isnan(criterion).all() else int(np.nanargmax(criterion))
