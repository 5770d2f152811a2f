"""Blocks of neighbouring frames, because a frame hardly differs from the one before it.

Source: Politis & White 2004, *Automatic block-length selection for the dependent bootstrap*, with the
correction of Patton, Politis & White 2009 (circular blocks, eq. for b_opt,CB).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pandas import DataFrame

FloatArray = NDArray[np.float64]


def autocovariance(series: FloatArray, lags: int) -> FloatArray:
    """(lags + 1,) float64: the biased autocovariance at lag 0 … lags."""
    x = series - series.mean()
    return np.array([float(x[: len(x) - k] @ x[k:]) / len(x) for k in range(lags + 1)])


def optimal_length(series: FloatArray) -> int:
    """The block length that a correlated series asks for, in samples, at least 1.

    Parameters
    ----------
    series : (n,) float64
        One value per frame, in the order of the frames.
    """
    n = len(series)
    if n < 8 or np.ptp(series) == 0.0:
        return 1
    longest = math.ceil(min(3.0 * math.sqrt(n), n / 3.0))
    quiet = max(5, math.ceil(math.sqrt(math.log10(n))))
    lags = min(n - 1, math.ceil(math.sqrt(n)) + quiet)
    covariance = autocovariance(series, lags)
    cut = min(2 * _last_correlated_lag(covariance / covariance[0], n, quiet), lags)
    if cut == 0:
        return 1
    k = np.arange(1, cut + 1)
    # flat-top window of Politis & Romano 1995: 1 up to half the cut, then falling to 0
    weight = np.minimum(1.0, 2.0 * (1.0 - k / cut)) * covariance[1 : cut + 1]
    spectrum = covariance[0] + 2.0 * weight.sum()
    slope = 2.0 * (weight * k).sum()
    if spectrum <= 0.0:
        return longest
    length = (2.0 * slope**2 / (4.0 / 3.0 * spectrum**2)) ** (1 / 3) * n ** (1 / 3)
    return int(np.clip(math.ceil(length), 1, longest))


def _last_correlated_lag(correlation: FloatArray, n: int, quiet: int) -> int:
    """The smallest lag after which ``quiet`` correlations in a row look like noise."""
    band = 2.0 * math.sqrt(math.log10(n) / n)
    loud = np.abs(correlation[1:]) >= band
    for lag in range(len(loud) - quiet + 1):
        if not loud[lag : lag + quiet].any():
            return lag
    return int(np.flatnonzero(loud)[-1]) + 1 if loud.any() else 0


def assign(frames: DataFrame, length: int) -> DataFrame:
    """The block of each frame: columns scene, frame, block.

    Frames of one scene are cut into contiguous blocks of ``length``, as evenly as can be; no block crosses
    from one scene into another. The same blocks serve each filter and each illumination.
    """
    import pandas as pd

    parts, first = [], 0
    for scene, group in frames.groupby("scene", sort=True):
        numbers = np.unique(group["frame"].to_numpy())
        count = max(1, len(numbers) // length)
        blocks = np.arange(len(numbers)) * count // len(numbers) + first
        parts.append(pd.DataFrame({"scene": scene, "frame": numbers, "block": blocks}))
        first += count
    return pd.concat(parts, ignore_index=True)
