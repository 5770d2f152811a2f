"""Highlights by colour thresholds and contrast to the surroundings (Arnold, Ghosh, Ameling & Lacey 2010,
"Automatic segmentation and inpainting of specular highlights for endoscopic imaging", EURASIP JIVP, section
2).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

FloatPicture = NDArray[np.float32]

_NEAR, _FAR = 2, 4  # pixels: the ring that gives a region its colour lies between these two dilations
_TINY = 10.0  # grey levels: no denominator is smaller, else the noise of black is contrast


@dataclass(frozen=True)
class Thresholds:
    """The paper's constants.

    Attributes
    ----------
    absolute : float
        T1 of module 1, grey levels.
    candidate : float
        T2abs of module 2, grey levels: what is painted over before the median.
    contrast : float
        T2rel of module 2.
    window : int
        Side of the median filter, pixels, odd (the paper's 30 has no centre).
    largest : int
        N_min: regions of more pixels have to show a steep contour.
    gradient : float
        T3, grey levels per pixel, of such a contour.
    """

    absolute: float = 240.0
    candidate: float = 180.0
    contrast: float = 1.0
    window: int = 31
    largest: int = 9000
    gradient: float = 5.0


def highlight_evidence(image: NDArray[np.uint8], thresholds: Thresholds) -> FloatPicture:
    """Find how far each pixel is above the thresholds: (H, W) float32, above 1 = a possible highlight.

    Module 1: c_E > T1, c_G > r_GE T1 or c_B > r_BE T1, with c_E the grey value and r the ratios of 95th
    percentiles, which make up for the colour balance. Module 2: the picture with its bright regions painted
    in the mean colour around each, median filtered, gives c*; a pixel stands out when max_c τ_c c / c*_c >
    T2rel, τ_c = mean / (mean + standard deviation) of the channel.
    """
    levels = image.astype(np.float32)
    bright = _balanced(image)
    median = cv2.medianBlur(_painted_over(image, bright > thresholds.candidate), thresholds.window)
    mean, deviation = (part.ravel() for part in cv2.meanStdDev(image))
    balance = (mean / np.maximum(mean + deviation, _TINY)).astype(np.float32)
    contrast = (levels / np.maximum(median, _TINY) * balance).max(axis=2)
    evidence = np.maximum(
        bright / np.float32(thresholds.absolute), contrast / np.float32(thresholds.contrast)
    )
    return np.asarray(evidence, dtype=np.float32)


def without_bright_areas(
    possible: NDArray[np.bool_], image: NDArray[np.uint8], thresholds: Thresholds
) -> NDArray[np.bool_]:
    """Drop large regions with a weak contour, which are bright but not specular; widen the rest by a pixel.

    The mean gradient magnitude in the one-pixel rim of a region of more than N_min pixels must reach T3.
    (Some public ports drop the small regions, or all large ones.)
    """
    mask = possible.astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    sizes = stats[:, cv2.CC_STAT_AREA]
    large = sizes > thresholds.largest
    large[0] = False
    if large.any():
        steepness = _gradient(_grey(image))
        rim = (mask > 0) & (cv2.erode(mask, np.ones((3, 3), dtype=np.uint8)) == 0)
        sums = np.bincount(labels[rim], weights=steepness[rim], minlength=count)
        lengths = np.maximum(np.bincount(labels[rim], minlength=count), 1)
        mask[(large & (sums / lengths < thresholds.gradient))[labels]] = 0
    return np.asarray(cv2.dilate(mask, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0)


def _grey(image: NDArray[np.uint8]) -> FloatPicture:
    """c_E: 0.2989 red + 0.5870 green + 0.1140 blue."""
    weights = np.array([[0.2989, 0.5870, 0.1140]], dtype=np.float32)
    return np.asarray(cv2.transform(image.astype(np.float32), weights), dtype=np.float32)


def _balanced(image: NDArray[np.uint8]) -> FloatPicture:
    """The largest of c_E, c_G / r_GE and c_B / r_BE, grey levels."""
    grey = _grey(image)
    top = _percentile(np.rint(grey).astype(np.uint8))
    brightest = grey
    for channel in (1, 2):
        part = image[..., channel]
        brightest = np.maximum(brightest, part * np.float32(top / _percentile(part)))
    return np.asarray(brightest, dtype=np.float32)


def _percentile(levels: NDArray[np.uint8]) -> float:
    """The 95th percentile, at least one level."""
    counts = np.cumsum(np.bincount(levels.ravel(), minlength=256))
    return max(float(np.searchsorted(counts, 0.95 * counts[-1])), _TINY)


def _painted_over(image: NDArray[np.uint8], bright: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Give each bright region the mean colour of the ring around it."""
    count, found = cv2.connectedComponents(bright.astype(np.uint8), connectivity=8)
    labels = np.asarray(found, dtype=np.int32)
    if count == 1:
        return np.ascontiguousarray(image)
    wide, narrow = (_widened(labels, reach) for reach in (_FAR, _NEAR))
    ring = (wide > 0) & (narrow == 0)
    owner = wide[ring]
    sizes = np.bincount(owner, minlength=count)
    colours = np.stack(
        [np.bincount(owner, weights=image[..., c][ring], minlength=count) for c in range(3)], axis=1
    )
    colours = np.rint(colours / np.maximum(sizes, 1)[:, None]).astype(np.uint8)
    painted = image.copy()
    inside = (labels > 0) & (sizes > 0)[labels]
    painted[inside] = colours[labels[inside]]
    return painted


def _widened(labels: NDArray[np.int32], reach: int) -> NDArray[np.int64]:
    """Labels grown by a disc; where two meet, the larger."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return np.asarray(cv2.dilate(labels.astype(np.float32), disc), dtype=np.int64)  # exact below 2²⁴


def _gradient(grey: FloatPicture) -> FloatPicture:
    """Magnitude of the differences to the next row and column, grey levels per pixel."""
    down = np.diff(grey, axis=0, append=grey[-1:])
    right = np.diff(grey, axis=1, append=grey[:, -1:])
    return np.asarray(np.hypot(down, right), dtype=np.float32)
