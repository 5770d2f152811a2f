"""Highlights as pixels brighter than their chromaticity (Meslouhi et al. 2011, "Automatic detection and
inpainting of specular reflections for colposcopic images", Cent. Eur. J. Comp. Sci. 1).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

# linear sRGB to CIE XYZ, IEC 61966-2-1
_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]], dtype=np.float32
)


def luminance_over_chromaticity(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Compare luminance Y and chromaticity y: (H, W) float32 Y − y, −1…1; 0 and more is a highlight.

    Each recorded colour is first scaled by s = min_c / max_c, which leaves white and darkens what has a
    colour; then Y and y = Y / (X + Y + Z) are those of the scaled colour. Black has no chromaticity and
    gives −1.
    """
    codes = image.astype(np.float32) / np.float32(255.0)
    largest = codes.max(axis=2)
    share = codes.min(axis=2) / np.maximum(largest, np.float32(1e-6))
    scaled = codes * share[..., None]
    # the exact table needs codes; scaled values are none
    linear = np.where(scaled <= 0.04045, scaled / 12.92, cv2.pow((scaled + 0.055) / 1.055, 2.4))
    xyz = cv2.transform(linear.astype(np.float32), _TO_XYZ)
    total = xyz.sum(axis=2)
    coloured = total > 1e-6
    luminance = xyz[..., 1]
    chromaticity = np.divide(luminance, total, out=np.ones_like(total), where=coloured)
    return np.asarray(np.clip(luminance - chromaticity, -1.0, 1.0), dtype=np.float32)
