"""Otsu's threshold (Otsu 1979, "A threshold selection method from gray-level histograms", eq. 18)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.filters.stages.valley_emphasis import best_level


def otsu(histogram: NDArray[np.int64]) -> int:
    """Find the threshold that separates two classes best: eq. 3-3 without its valley factor.

    The between-class variance is ω1 μ1² + ω2 μ2² less the square of the mean of all, which is the same for
    all thresholds.

    Parameters
    ----------
    histogram : (256,) int64
        Counts of the grey levels 0…255.

    Returns
    -------
    int
        t*, 0…255, the highest level of the lower class; 255 where nothing is separated.
    """
    return best_level(histogram, valley=False)
