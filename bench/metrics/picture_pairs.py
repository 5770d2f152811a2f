"""Picture pairs: how the literature of highlight removal scores a repaired picture against its diffuse one.

Sources
-------
PSNR = 10 log10(R² / MSE). SSIM: Wang, Bovik, Sheikh & Simoncelli 2004, eq. 13. LMSE: Grosse, Johnson,
Adelson & Freeman 2009, "Ground truth dataset and baseline evaluations for intrinsic image algorithms",
section 4.3. ΔE2000: CIE 142-2001 (Sharma, Wu & Dalal 2005), through colour-science.

Conventions
-----------
- Pictures are (H, W, 3) float64, 0…1, in the encoding that their files have: tables of the field are
  computed on linear pictures, others on sRGB ones, and the two differ by decibels. The data range is 1.
- MSE is over all three channels. ``psnr_in_mask_db`` is over the affected pixels of the **true** mask, NaN
  where it is empty. A perfect picture has +inf.
- ``ssim`` is the mean over the three channels, 11 × 11 Gaussian window (σ = 1.5), over windows wholly
  inside the picture; NaN for a picture with a side below 11. ``ssim_volume`` is what MATLAB's ``ssim(A,
  REF)`` gives for an M × N × 3 array, which it takes for a volume: an 11 × 11 × 11 Gaussian, edges
  repeated, the mean over all pixels. The field's tables hold that one as a rule; it is higher.
- ``lmse``: in windows of 20 × 20 pixels, half overlapping, the squared error that the best factor for that
  window leaves, over the target's energy: 0 is perfect, and 1 is what a black picture has. A window's three
  channels share one factor. A smaller picture is one window.
- ``delta_e``: mean ΔE2000 over the pixels, lightness relative to white at 1, D65; 1 is about what an eye
  can tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError
from bench.metrics.restoration import psnr_db
from bench.metrics.structural_similarity import K1, K2, RADIUS, SIGMA

FloatArray = NDArray[np.float64]

WINDOW, SHIFT = 20, 10  # pixels, of LMSE (Grosse et al. 2009)
BLACK_ENERGY = 1e-5
"""A window of the estimate with less energy has no best factor (as in the authors' own code)."""


@dataclass(frozen=True)
class PairScores:
    """Scores of one repaired picture; the names are those of `bench.schema.PICTURE_COLUMNS`.

    Attributes
    ----------
    psnr_db, psnr_in_mask_db : float
        dB; inf for a perfect picture.
    ssim, ssim_volume : float
        −1…1.
    lmse : float
        0…1 for anything better than black; lower is better.
    delta_e : float
        ≥ 0; lower is better.
    """

    psnr_db: float
    psnr_in_mask_db: float
    ssim: float
    ssim_volume: float
    lmse: float
    delta_e: float


def validate(repaired: FloatArray, target: FloatArray, mask: NDArray[np.bool_]) -> None:
    """Refuse what is not two pictures and a mask of one scene.

    Raises
    ------
    BenchError
        On another type, on shapes that differ, on an empty picture, on values that are not finite in 0…1.
    """
    for role, picture in (("repaired", repaired), ("target", target)):
        if picture.dtype != np.float64 or picture.ndim != 3 or picture.shape[2] != 3 or picture.size == 0:
            raise BenchError(
                f"pair metrics: the {role} picture is {picture.dtype} {picture.shape}; "
                "give (H, W, 3) float64 in 0…1"
            )
        if not (picture.min() >= 0.0 and picture.max() <= 1.0):  # a NaN fails both
            raise BenchError(
                f"pair metrics: the {role} picture spans {picture.min()}…{picture.max()}; it must lie in 0…1"
            )
    if repaired.shape != target.shape:
        raise BenchError(f"pair metrics: the repaired picture is {repaired.shape}, its target {target.shape}")
    if mask.dtype != np.bool_ or mask.shape != target.shape[:2]:
        raise BenchError(f"pair metrics: the mask is {mask.dtype} {mask.shape}; give bool {target.shape[:2]}")


def evaluate(repaired: FloatArray, target: FloatArray, mask: NDArray[np.bool_], linear: bool) -> PairScores:
    """Score one repaired picture.

    Parameters
    ----------
    repaired, target : (H, W, 3) float64
        0…1, in one encoding.
    mask : (H, W) bool
        The true mask.
    linear : bool
        Whether the numbers are linear light; otherwise they are sRGB. Only ``delta_e`` depends on it.

    Raises
    ------
    BenchError
        When the three do not fit together; see ``validate``.
    """
    validate(repaired, target, mask)
    squared = (repaired - target) ** 2
    return PairScores(
        psnr_db=psnr_db(float(squared.mean()), 1.0),
        psnr_in_mask_db=psnr_db(float(squared[mask].mean()), 1.0) if mask.any() else math.nan,
        ssim=ssim(repaired, target),
        ssim_volume=ssim_volume(repaired, target),
        lmse=lmse(repaired, target),
        delta_e=delta_e(repaired, target, linear),
    )


def ssim(repaired: FloatArray, target: FloatArray) -> float:
    """Mean structural similarity of the channels, windows wholly inside; NaN where none fits."""
    if min(target.shape[:2]) < 2 * RADIUS + 1:
        return math.nan

    def blurred(picture: FloatArray) -> FloatArray:
        size = (2 * RADIUS + 1,) * 2
        whole = cv2.GaussianBlur(picture, size, SIGMA, borderType=cv2.BORDER_REFLECT)
        return np.asarray(whole[RADIUS:-RADIUS, RADIUS:-RADIUS])

    return float(_similarity(repaired, target, blurred).mean())


def ssim_volume(repaired: FloatArray, target: FloatArray) -> float:
    """MATLAB's ``ssim`` of an M × N × 3 array: the channels are a third axis of space."""
    from scipy.ndimage import gaussian_filter

    def blurred(picture: FloatArray) -> FloatArray:
        return np.asarray(gaussian_filter(picture, SIGMA, mode="nearest", radius=RADIUS))

    return float(_similarity(repaired, target, blurred).mean())


def lmse(repaired: FloatArray, target: FloatArray) -> float:
    """Local mean squared error with the best factor in each window, over the target's energy (Grosse 2009).

    NaN for a black target, which has no energy to compare with.
    """
    product, own, energy = (
        _window_sums((a * b).sum(axis=2))
        for a, b in ((repaired, target), (repaired, repaired), (target, target))
    )
    explained = np.where(own > BLACK_ENERGY, product**2 / np.maximum(own, BLACK_ENERGY), 0.0)
    total = float(energy.sum())
    return float(np.maximum(energy - explained, 0.0).sum()) / total if total > 0.0 else math.nan


def delta_e(repaired: FloatArray, target: FloatArray, linear: bool) -> float:
    """Mean CIEDE2000 over the pixels."""
    import colour

    return float(np.mean(colour.delta_E(_lab(repaired, linear), _lab(target, linear), method="CIE 2000")))


def _similarity(one: FloatArray, other: FloatArray, blurred):  # type: ignore[no-untyped-def]
    """Eq. 13 in each window; the data range is 1."""
    mean_one, mean_other = blurred(one), blurred(other)
    variances = blurred(one * one) - mean_one**2 + blurred(other * other) - mean_other**2
    covariance = blurred(one * other) - mean_one * mean_other
    luminance = (2 * mean_one * mean_other + K1**2) / (mean_one**2 + mean_other**2 + K1**2)
    return luminance * (2 * covariance + K2**2) / (variances + K2**2)


def _window_sums(values: FloatArray) -> FloatArray:
    """Sums over windows of `WINDOW` pixels, `SHIFT` apart; over the whole of a shorter side."""
    for axis in (0, 1):
        length = values.shape[axis]
        size = min(WINDOW, length)
        sums = np.cumsum(values, axis=axis)
        sums = np.concatenate([np.zeros_like(np.take(sums, [0], axis)), sums], axis=axis)
        first = np.arange(0, length - size + 1, SHIFT)
        values = np.take(sums, first + size, axis) - np.take(sums, first, axis)
    return values


def _lab(picture: FloatArray, linear: bool) -> FloatArray:
    import colour

    space = colour.RGB_COLOURSPACES["sRGB"]
    light = picture if linear else space.cctf_decoding(picture)
    return np.asarray(colour.XYZ_to_Lab(light @ space.matrix_RGB_to_XYZ.T, space.whitepoint))
