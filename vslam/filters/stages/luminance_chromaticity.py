"""Highlights as pixels brighter than their chromaticity (Meslouhi et al. 2011, "Automatic detection and
inpainting of specular reflections for colposcopic images", Cent. Eur. J. Comp. Sci. 1).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def luminance_over_chromaticity(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Compare luminance Y and chromaticity y: (H, W) float32 Y − y, −1…1; 0 and more is a highlight.

    Each recorded colour is first scaled by s = min_c / max_c, which leaves white and darkens what has a
    colour; then Y and y = Y / (X + Y + Z) are those of the scaled colour. Black has no chromaticity and
    gives −1.
    """
    excess: NDArray[np.float32] = _excess(np.ascontiguousarray(image))
    return excess


@njit("float64(float64)", cache=True)
def _linear(encoded):  # type: ignore[no-untyped-def]
    """IEC 61966-2-1 by the formula: the scaled values are no codes."""
    return encoded / 12.92 if encoded <= 0.04045 else ((encoded + 0.055) / 1.055) ** 2.4


@njit("float32[:, ::1](Array(uint8, 3, 'C', readonly=True))", cache=True)
def _excess(image):  # type: ignore[no-untyped-def]
    height, width = image.shape[:2]
    excess = np.full((height, width), -1.0, dtype=np.float32)
    for row in range(height):
        for column in range(width):
            codes = image[row, column]
            largest = max(codes[0], codes[1], codes[2])
            smallest = min(codes[0], codes[1], codes[2])
            if smallest == 0:  # scaled to black
                continue
            share = smallest / largest / 255.0
            red, green, blue = _linear(share * codes[0]), _linear(share * codes[1]), _linear(share * codes[2])
            # linear sRGB to CIE XYZ, IEC 61966-2-1: Y, and X + Y + Z
            luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue
            total = 0.6443 * red + 1.1920 * green + 1.2032 * blue
            excess[row, column] = luminance - luminance / total
    return excess
