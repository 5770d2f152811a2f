"""The plain NumPy form of the filter ``seed``: what one would write first, as the baseline of benchmarks.

The same eqs. 3-2 … 3-5 with the same choices as `vslam.filters.seed`, step by step on whole arrays: minima
and maxima over a patch as those of shifted copies, first along columns, then along rows; sRGB decoded by a
table of its 256 values, encoded by its formula inside the mask.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered

PATCH = 15
GREY, DARKEST = 1 / 3 + 0.01, 40

FloatArray = NDArray[np.float64]


def seed(image: NDArray[np.uint8]) -> Filtered:
    """Filter an (H, W, 3) uint8 sRGB picture."""
    dark = over_patch(np.minimum, image.min(axis=2), 255)
    mask = dark > valley_emphasis(dark)
    free = ~over_patch(np.logical_or, mask, 0)
    linear = DECODED[image]
    lambda_max = median_chromaticity(image[::2], linear[::2], free[::2])
    repaired = image.copy()
    if lambda_max > GREY:
        masked = linear[mask]
        specular = (masked.max(axis=1) - lambda_max * masked.sum(axis=1)) / (1 - 3 * lambda_max)
        specular = np.clip(specular, 0, masked.min(axis=1))
        repaired[mask] = np.rint(255 * encode(masked - specular[:, None]))
    return Filtered(repaired, mask, (dark / 255).astype(np.float32))


def over_patch(smaller: Callable[..., Any], values: NDArray[Any], border: int) -> NDArray[Any]:
    """A minimum or maximum over the square patch around each pixel; the border stands for what is outside."""
    half = PATCH // 2
    padded = np.pad(values, half, constant_values=border)
    height, width = values.shape
    rows = padded[:height]
    for k in range(1, PATCH):
        rows = smaller(rows, padded[k : k + height])
    result = rows[:, :width]
    for k in range(1, PATCH):
        result = smaller(result, rows[:, k : k + width])
    return np.asarray(result)


def valley_emphasis(dark: NDArray[np.uint8]) -> int:
    """Eq. 3-3."""
    p = np.bincount(dark.ravel(), minlength=256) / dark.size
    below, level = np.cumsum(p), np.arange(256)
    above, sums = 1 - below, np.cumsum(p * level)
    with np.errstate(divide="ignore", invalid="ignore"):
        criterion = (1 - p) * (sums**2 / below + (sums[-1] - sums) ** 2 / above)
    criterion[(below <= 0) | (np.cumsum(p[::-1])[::-1] - p <= 1e-12)] = -1
    return int(np.argmax(criterion)) if criterion.max() >= 0 else 255


def median_chromaticity(image: NDArray[np.uint8], linear: FloatArray, free: NDArray[np.bool_]) -> float:
    """Λmax: the median of max_c I_c / Σ_c I_c over the usable pixels that no highlight touches."""
    brightest = image.max(axis=2)
    usable = linear[free & (brightest >= DARKEST) & (brightest < 255)]
    return float(np.median(usable.max(axis=1) / usable.sum(axis=1))) if len(usable) else 0.0


def decode(codes: NDArray[np.uint8]) -> FloatArray:
    """IEC 61966-2-1."""
    encoded = codes / 255
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


DECODED = decode(np.arange(256, dtype=np.uint8))


def encode(linear: FloatArray) -> FloatArray:
    """IEC 61966-2-1."""
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
