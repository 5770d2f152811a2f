"""Exposure fusion (Mertens, Kautz & Van Reeth 2007, "Exposure fusion", Pacific Graphics).

As OpenCV's ``MergeMertens``, which serves as the test's oracle; its last bits differ from call to call, and a
filter has to give the same picture for the same picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

FloatPicture = NDArray[np.float32]

WELL_EXPOSED = 0.2  # standard deviation around one half, the paper's section 3.1
_LEAST = np.float32(1e-12)  # where every picture has weight 0 (grey, flat) they count alike


def fused(bracket: Sequence[NDArray[np.uint8]]) -> FloatPicture:
    """Blend pictures by contrast × saturation × well-exposedness on Laplacian pyramids (eqs. 1 … 4).

    Parameters
    ----------
    bracket : sequence of (H, W, 3) uint8
        The same view, differently exposed, encoded.

    Returns
    -------
    (H, W, 3) float32
        Encoded, 0…1.
    """
    pictures = [picture.astype(np.float32) / np.float32(255.0) for picture in bracket]
    weights = [_weight(picture) for picture in pictures]
    total = np.sum(weights, axis=0)
    levels = int(np.log2(min(pictures[0].shape[:2])))
    blended: list[FloatPicture] = []
    for picture, weight in zip(pictures, weights, strict=True):
        shares = _gaussian(weight / total, levels)
        parts = [d * share[..., None] for d, share in zip(_laplacian(picture, levels), shares, strict=True)]
        blended = [one + other for one, other in zip(blended, parts, strict=True)] if blended else parts
    result = blended[-1]
    for detail in blended[-2::-1]:
        result = detail + _up(result, detail)
    return np.asarray(np.clip(result, 0.0, 1.0), dtype=np.float32)


def _weight(picture: FloatPicture) -> FloatPicture:
    """Eq. 1 with all exponents 1, (H, W)."""
    contrast = np.abs(cv2.Laplacian(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), cv2.CV_32F))
    mean = picture.mean(axis=2, keepdims=True)
    saturation = np.sqrt(np.square(picture - mean).sum(axis=2))
    exposedness = np.exp(-np.square(picture - np.float32(0.5)).sum(axis=2) / np.float32(2 * WELL_EXPOSED**2))
    return np.asarray(contrast * saturation * exposedness + _LEAST, dtype=np.float32)


def _gaussian(picture: FloatPicture, levels: int) -> list[FloatPicture]:
    pyramid = [picture]
    for _ in range(levels):
        pyramid.append(np.asarray(cv2.pyrDown(pyramid[-1]), dtype=np.float32))
    return pyramid


def _laplacian(picture: FloatPicture, levels: int) -> list[FloatPicture]:
    pyramid = _gaussian(picture, levels)
    details = [fine - _up(coarse, fine) for fine, coarse in pairwise(pyramid)]
    return [*details, pyramid[-1]]


def _up(coarse: FloatPicture, fine: FloatPicture) -> FloatPicture:
    """The coarser picture in the size of the finer one."""
    return np.asarray(cv2.pyrUp(coarse, dstsize=(fine.shape[1], fine.shape[0])), dtype=np.float32)
