"""Diffuse light from the modified specular-free picture (Shen & Cai 2009, "Simple and efficient method for
specularity removal in an image", Applied Optics 48).

Without its smallest channel a pixel is free of white light, and of some of its own colour; an offset gives
the colour back. What lies above the offset is specular up to one factor for the picture, found at the
border of the largest highlight, on both sides of which the surface is the same.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SPECULAR_DEGREE = 0.5  # η of the threshold T = mean + η standard deviations; the paper's section 3
HIGHLIGHT = 0.1  # of the largest pseudo-specular value: a highlight, as the paper's public MATLAB code has it
RING = 5  # pixels, side of the square by which the highlight is widened to its surroundings; as there


def diffuse_by_offset(linear: NDArray[np.float32], degree: float = SPECULAR_DEGREE) -> NDArray[np.float32]:
    """Separate the diffuse part.

    T = mean(I_min) + η sd(I_min); β = max(I_min − T, 0) is the pseudo-specular part, I − β the modified
    specular-free picture. D is the largest connected region with β above a tenth of its maximum and R the
    ring around it; k = min_c (mean_D I_c − mean_R I_c) / (mean_D β − mean_R β) makes the diffuse colours of
    both agree; I − k β is the diffuse part. The channel of the smallest k has least of the shading in it.

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear light, white-balanced.
    degree : float
        η.

    Returns
    -------
    (H, W, 3) float32
        0 … ``linear``; ``linear`` itself where no pixel lies above T or the highlight fills the picture.
    """
    smallest = cv2.min(cv2.min(linear[..., 0], linear[..., 1]), linear[..., 2])
    mean, deviation = (float(value[0, 0]) for value in cv2.meanStdDev(smallest))
    specular = np.maximum(smallest - np.float32(mean + degree * deviation), 0)
    factor = _factor(linear, specular)
    part = np.clip(factor * specular, 0, smallest)
    return np.asarray(linear - part[..., None], dtype=np.float32)


def _factor(linear: NDArray[np.float32], specular: NDArray[np.float32]) -> np.float32:
    """k, at least 0."""
    highlight = (specular > HIGHLIGHT * specular.max()).astype(np.uint8)
    count, labels, sizes, _ = cv2.connectedComponentsWithStats(highlight, connectivity=8)
    if count < 2:
        return np.float32(0)
    region = (labels == 1 + np.argmax(sizes[1:, cv2.CC_STAT_AREA])).astype(np.uint8)
    ring = cv2.dilate(region, np.ones((RING, RING), dtype=np.uint8)) - region
    if not ring.any():
        return np.float32(0)
    colour = np.subtract(cv2.mean(linear, region)[:3], cv2.mean(linear, ring)[:3])
    step = cv2.mean(specular, region)[0] - cv2.mean(specular, ring)[0]
    return np.float32(max(colour.min() / step, 0.0) if step > 0 else 0.0)
