"""The stages of the dissertation's filter in order: what the registered filters run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from vslam.filters.base import Filtered
from vslam.filters.stages.bilateral_propagation import propagated_chromaticity
from vslam.filters.stages.dark_channel import dark_channel
from vslam.filters.stages.light_mask import highlight_free, light_mask
from vslam.filters.stages.maximum_chromaticity import picture_chromaticity
from vslam.filters.stages.otsu import otsu
from vslam.filters.stages.specular_to_diffuse import repair_masked
from vslam.filters.stages.srgb import READABLE_CODES
from vslam.filters.stages.transfer import PROPORTIONAL, SRGB, Transfer
from vslam.filters.stages.valley_emphasis import grey_histogram, valley_emphasis

THRESHOLDS: dict[str, Callable[[NDArray[np.int64]], int]] = {"valley-emphasis": valley_emphasis, "otsu": otsu}
"""Rules for eq. 3-3 by name."""
QUANTILES = {"maximum": 1.0, "median": 0.5}
"""Which quantile of the highlight-free chromaticities each rule of one Λmax per picture takes."""
PER_PIXEL = "per-pixel"


@dataclass(frozen=True)
class Choices:
    """What the dissertation leaves open.

    Attributes
    ----------
    patch : int
        Side of the dark channel's patch, pixels, odd.
    threshold : str or int
        A key of ``THRESHOLDS``, or the grey level itself.
    chromaticity : str
        A key of ``QUANTILES``, or ``PER_PIXEL``.
    linear : bool
        Whether eq. 3-5 is computed in linear light.
    passes : int
        Of the propagation, with ``PER_PIXEL``.
    """

    patch: int
    threshold: str | int
    chromaticity: str
    linear: bool
    passes: int


def repair(image: NDArray[np.uint8], choices: Choices) -> Filtered:
    """Eqs. 3-2 … 3-5.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB, white-balanced.
    choices : Choices

    Returns
    -------
    Filtered
        With the dark channel over 255 as the score: the soft value that the mask is cut from.
    """
    image = np.ascontiguousarray(image)
    transfer = SRGB if choices.linear else PROPORTIONAL
    dark, mask = detect(image, choices.patch, choices.threshold)
    lambda_max = _chromaticity(image, mask, choices, transfer)
    repaired = repair_masked(image, mask, lambda_max, transfer)
    return Filtered(repaired, mask, np.asarray(_over_255(dark.reshape(-1))).reshape(mask.shape))


def detect(
    image: NDArray[np.uint8], patch: int, threshold: str | int
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Find dark channel (H, W) uint8 and mask (H, W) bool, eqs. 3-2 … 3-4, on the values as recorded."""
    dark = dark_channel(image, patch)
    level = THRESHOLDS[threshold](grey_histogram(dark)) if isinstance(threshold, str) else threshold
    return dark, light_mask(dark, level)


@njit(types.float32[::1](READABLE_CODES), error_model="numpy", cache=True)
def _over_255(codes):  # type: ignore[no-untyped-def]
    shares = np.empty(codes.size, dtype=np.float32)
    for i in range(codes.size):
        shares[i] = np.float32(codes[i]) / np.float32(255)
    return shares


def _chromaticity(
    image: NDArray[np.uint8], mask: NDArray[np.bool_], choices: Choices, transfer: Transfer
) -> float | NDArray[np.float32]:
    """Λmax: one, or (H, W) float32."""
    if choices.chromaticity == PER_PIXEL:
        return propagated_chromaticity(transfer.decode(image), choices.passes)
    quantile = QUANTILES[choices.chromaticity]
    every = 2 if 0.0 < quantile < 1.0 else 1
    free = highlight_free(mask, choices.patch, every)
    return picture_chromaticity(image, free, quantile, transfer.decoded, every)
