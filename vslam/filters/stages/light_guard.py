"""What `guarded` makes of the network's answer: a mask of certain highlights, the picture repaired there."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered
from vslam.filters.stages.light_network import LightNetwork, shrink_factor

SHARE_BIAS = -3.0
"""Added to the logits of the shares: a network that knows nothing starts by taking next to nothing away."""

LEAST_RANGE = 16
"""Grey levels: the suite's τ. A picture that spans fewer holds nothing that added so many to a few pixels."""

# The logistic function by look-up: steps of 1/32 over ±16 are 0.008 of a chance or less, linear between them
_STEPS, _LIMIT = 32, 16
_LOGISTIC = (1.0 / (1.0 + np.exp(-np.arange(-_LIMIT * _STEPS, _LIMIT * _STEPS + 2) / _STEPS))).astype(
    np.float32
)


@dataclass(frozen=True)
class Guard:
    """When to touch a pixel.

    Attributes
    ----------
    likely, certain : float
        Chance above which a pixel may belong to a highlight, and which a highlight must exceed on average.
    least : int
        Pixels (of the network's resolution) below which a region is no highlight.
    strength : float
        How much of the light a repair takes away where the chance is 1. A repair that is a little wrong
        draws edges, which cost a detector more than some light that stays.

    Raises
    ------
    VslamError
        When the two chances are not in order, or the strength is not within 0…1.
    """

    likely: float
    certain: float
    least: int
    strength: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.likely <= self.certain < 1.0:
            raise VslamError(
                f"light filter 'guarded': likely {self.likely}, certain {self.certain}: must rise within 0…1"
            )
        if not 0.0 < self.strength <= 1.0:
            raise VslamError(f"light filter 'guarded': strength {self.strength}: must lie within 0…1")


def guarded(image: NDArray[np.uint8], network: LightNetwork, guard: Guard) -> Filtered:
    """Detect and repair.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB.

    Returns
    -------
    Filtered
        With the chance of a highlight as the score.
    """
    image = np.ascontiguousarray(image)
    height, width = image.shape[:2]
    least, most = cv2.minMaxLoc(image.reshape(height, -1))[:2]  # many times as fast as NumPy's
    if most - least < LEAST_RANGE:
        return _untouched(image, np.zeros((height, width), dtype=np.float32))
    factor = shrink_factor(height, width)
    seen = shrunk(image, factor)
    logits = network(seen)
    chance = highlight_chance(logits, *seen.shape[:2])
    regions = certain_regions(chance, guard)
    score = chance if factor == 1 else _enlarged(chance, height, width)
    if not regions.any():
        return _untouched(image, score)
    around = cv2.dilate(regions.view(np.uint8), np.ones((3, 3), dtype=np.uint8))
    left = _kept_shares(around, chance, logits, guard.likely, guard.strength, _LOGISTIC)
    if factor == 1:
        return Filtered(_scaled(image, regions, left), regions, score)
    kept = _enlarged(left, height, width)
    # a region's border runs where the enlarged chance says, which is smoother than its pixels enlarged
    mask = (_enlarged(chance * around, height, width) > np.float32(guard.likely)) & (
        cv2.resize(around, (width, height), interpolation=cv2.INTER_NEAREST) > 0
    )
    return Filtered(_scaled(image, mask, kept), mask, score)


def highlight_chance(logits: NDArray[np.float32], height: int, width: int) -> NDArray[np.float32]:
    """Chance of a highlight, 0…1: (height, width) float32 from the (16, H/2, W/2) logits by cell."""
    chance: NDArray[np.float32] = _chance(np.ascontiguousarray(logits), height, width, _LOGISTIC)
    return chance


def shrunk(image: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """The picture as the network takes it: (H / factor, W / factor, 3) uint8."""
    if factor == 1:
        return image
    height, width = (max(1, round(side / factor)) for side in image.shape[:2])
    return np.asarray(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def certain_regions(chance: NDArray[np.float32], guard: Guard) -> NDArray[np.bool_]:
    """Regions of likely pixels, 8-connected, certain on average and large enough: (H, W) bool."""
    if not chance.max() > guard.certain:
        return np.zeros(chance.shape, dtype=np.bool_)
    likely = chance > np.float32(guard.likely)
    count, labels = cv2.connectedComponents(likely.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    kept: NDArray[np.bool_] = _kept(labels, chance, count, guard.certain, guard.least)
    return kept


def _untouched(image: NDArray[np.uint8], score: NDArray[np.float32]) -> Filtered:
    return Filtered(image.copy(), np.zeros(image.shape[:2], dtype=np.bool_), score)


def _enlarged(values: NDArray[np.float32], height: int, width: int) -> NDArray[np.float32]:
    return np.asarray(cv2.resize(values, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)


@njit("float32(float32, float32[::1])", cache=True)
def _logistic(logit, table):  # type: ignore[no-untyped-def]
    position = min(max((logit + _LIMIT) * _STEPS, 0.0), 2.0 * _LIMIT * _STEPS)
    step = int(position)
    return np.float32(table[step] + (position - step) * (table[step + 1] - table[step]))


@njit("float32(float32[:, :, ::1], int64, int64, int64, float32[::1])", cache=True)
def _left(logits, row, column, channel, table):  # type: ignore[no-untyped-def]
    """What light did not add of a pixel's code in a channel, as a share."""
    logit = logits[4 * (channel + 1) + 2 * (row % 2) + column % 2, row // 2, column // 2]
    return _logistic(np.float32(-SHARE_BIAS) - logit, table)


@njit("float32[:, ::1](float32[:, :, ::1], int64, int64, float32[::1])", cache=True)
def _chance(logits, height, width, table):  # type: ignore[no-untyped-def]
    chance = np.empty((height, width), dtype=np.float32)
    for row in range(height):
        for column in range(width):
            logit = logits[2 * (row % 2) + column % 2, row // 2, column // 2]
            chance[row, column] = _logistic(logit, table)
    return chance


@njit("boolean[:, ::1](int32[:, ::1], float32[:, ::1], int64, float64, int64)", cache=True)
def _kept(labels, chance, count, certain, least):  # type: ignore[no-untyped-def]
    total, size = np.zeros(count, dtype=np.float64), np.zeros(count, dtype=np.int64)
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            label = labels[row, column]
            if label > 0:
                size[label] += 1
                total[label] += chance[row, column]
    keep = (total > certain * size) & (size >= least)
    kept = np.zeros(labels.shape, dtype=np.bool_)
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            kept[row, column] = keep[labels[row, column]]
    return kept


@njit(
    "float32[:, :, ::1](uint8[:, ::1], float32[:, ::1], float32[:, :, ::1], float64, float64, float32[::1])",
    cache=True,
)
def _kept_shares(around, chance, logits, likely, strength, table):  # type: ignore[no-untyped-def]
    """(H, W, 3): what stays of each code, 0…1; all of it where no region is near.

    The share of light counts the less the nearer the chance is to just likely, so the border of a repair
    leaves no edge, which a detector of discs would see.
    """
    height, width = chance.shape
    kept = np.ones((height, width, 3), dtype=np.float32)
    steep = np.float32(strength / (1 - likely))
    for row in range(height):
        for column in range(width):
            sure = (chance[row, column] - np.float32(likely)) * steep
            if around[row, column] and sure > 0:
                for c in range(3):
                    kept[row, column, c] = 1 - sure * (1 - _left(logits, row, column, c, table))
    return kept


@njit(
    "uint8[:, :, ::1](Array(uint8, 3, 'C', readonly=True), boolean[:, ::1], float32[:, :, ::1])", cache=True
)
def _scaled(image, mask, kept):  # type: ignore[no-untyped-def]
    """Each channel's code times what stays of it, inside the mask: the picture's own detail stays."""
    repaired = image.copy()
    for row in range(mask.shape[0]):
        for column in range(mask.shape[1]):
            if mask[row, column]:
                for c in range(3):
                    left = image[row, column, c] * kept[row, column, c]
                    repaired[row, column, c] = np.uint8(left + np.float32(0.5))
    return repaired
