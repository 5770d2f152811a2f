"""The stages in order: what the registered filters run."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered
from vslam.filters.stages.chromaticity_map import chromaticity_map
from vslam.filters.stages.dark_channel import dark_channel
from vslam.filters.stages.light_mask import highlight_free, light_mask
from vslam.filters.stages.maximum_chromaticity import picture_chromaticity
from vslam.filters.stages.specular_to_diffuse import repair_masked
from vslam.filters.stages.valley_emphasis import grey_histogram, valley_emphasis

_SCORES = (np.arange(256) / 255.0).astype(np.float32)


def repair_with_one_chromaticity(image: NDArray[np.uint8], patch: int, quantile: float) -> Filtered:
    """Eqs. 3-2 … 3-5 with one Λmax for the whole picture.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB, white-balanced.
    patch : int
        Side of the dark channel's patch, pixels, odd.
    quantile : float
        Of the highlight-free chromaticities, see ``picture_chromaticity``.

    Returns
    -------
    Filtered
        With the dark channel over 255 as the score: the soft value that the mask is cut from.
    """
    image = _plain(image)
    dark, mask = detect(image, patch)
    lambda_max = picture_chromaticity(image, highlight_free(mask, patch), quantile)
    return _filtered(image, dark, mask, np.full(mask.shape, lambda_max, dtype=np.float32))


def repair_with_chromaticity_map(image: NDArray[np.uint8], patch: int) -> Filtered:
    """Eqs. 3-2 … 3-5 with a Λmax for each pixel; parameters, result as ``repair_with_one_chromaticity``."""
    image = _plain(image)
    dark, mask = detect(image, patch)
    lambda_max = chromaticity_map(image, mask, highlight_free(mask, patch))
    return _filtered(image, dark, mask, lambda_max)


def detect(image: NDArray[np.uint8], patch: int) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Find dark channel (H, W) uint8 and mask (H, W) bool, eqs. 3-2 … 3-4, on the values as recorded."""
    dark = dark_channel(image, patch)
    threshold = valley_emphasis(grey_histogram(dark))
    return dark, light_mask(dark, threshold)


def _plain(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Give the memory layout that the kernels take: copy views and read-only (memory-mapped) pictures."""
    return np.require(image, requirements=["C", "W"])


def _filtered(
    image: NDArray[np.uint8],
    dark: NDArray[np.uint8],
    mask: NDArray[np.bool_],
    lambda_max: NDArray[np.float32],
) -> Filtered:
    repaired = repair_masked(image, mask, lambda_max)
    return Filtered(repaired, mask, np.asarray(cv2.LUT(dark, _SCORES), dtype=np.float32))
