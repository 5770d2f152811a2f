"""Restoration: how close a repaired picture comes to the picture without specular light.

Sources
-------
PSNR = 10 log10(R² / MSE), R the data range. SSIM: Wang, Bovik, Sheikh & Simoncelli 2004,
"Image quality assessment: from error visibility to structural similarity", eq. 13, with its Gaussian
window (11 × 11, σ = 1.5) and K1 = 0.01, K2 = 0.03.

Conventions
-----------
- Pictures are compared as recorded: sRGB codes, not linear light. The target is the diffuse picture.
- MSE is over all three channels. ``psnr_in_mask_db`` is over the pixels of the **true** mask, the same
  for each filter, and NaN where that mask is empty. Over the whole frame the untouched pixels drown the
  difference between filters.
- The PSNR of a perfect picture is +inf by definition, and is stored as such: no cap. Dropping it would
  punish the best pictures and one of them makes the plain mean infinite, so average with
  ``mean_psnr_db``: back to MSE, mean, to decibels again. That is the PSNR of all pictures seen as one;
  NaN is left out.
- SSIM is the mean over the three channels and over the windows that lie wholly inside the picture;
  scikit-image's ``structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
  channel_axis=-1)`` to 1e-6.
- ``data_range`` is what black and white are apart (255 for 8 bits); it is never guessed from the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench.errors import BenchError
from bench.metrics.structural_similarity import RADIUS, moments, structural_similarity

WINDOW = 2 * RADIUS + 1


@dataclass(frozen=True)
class RestorationScores:
    """Scores of one repaired picture.

    Attributes
    ----------
    psnr_db : float
        Over the whole frame, dB; inf for a perfect picture.
    ssim : float
        −1…1.
    psnr_in_mask_db : float
        Over the true mask, dB; NaN where that is empty.
    """

    psnr_db: float
    ssim: float
    psnr_in_mask_db: float


class Target:
    """A restoration target with its local moments, for scoring several filters against one picture.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        The picture to reach; not changed and not copied.

    Raises
    ------
    BenchError
        When ``picture`` is no 8-bit picture of at least 11 × 11 pixels.
    """

    def __init__(self, picture: NDArray[np.uint8]) -> None:
        _check_picture("target", picture)
        self.picture = picture
        self.moments = moments(picture)


def validate(picture: NDArray[np.uint8], target: Target, mask: NDArray[np.bool_], data_range: float) -> None:
    """Refuse what is not a picture, its target and a mask of one frame.

    Raises
    ------
    BenchError
        On another type, on shapes that differ, on a data range that is not positive.
    """
    _check_picture("repaired", picture)
    if picture.shape != target.picture.shape:
        raise BenchError(
            f"restoration metrics: the repaired picture is {picture.shape}, its target {target.picture.shape}"
        )
    if mask.dtype != np.bool_ or mask.shape != picture.shape[:2]:
        raise BenchError(
            f"restoration metrics: the mask is {mask.dtype} {mask.shape}; give bool {picture.shape[:2]}"
        )
    if not (math.isfinite(data_range) and data_range > 0):
        raise BenchError(f"restoration metrics: data_range {data_range} must be positive, 255 for 8 bits")


def psnr_db(mse: float, data_range: float = 255.0) -> float:
    """10 log10(R² / MSE); inf for an MSE of 0, NaN for NaN."""
    if mse == 0.0:
        return math.inf
    return 10.0 * math.log10(data_range**2 / mse)


def mean_psnr_db(values: ArrayLike) -> float:
    """Give the PSNR of several pictures seen as one: the mean of their MSE in decibels.

    Parameters
    ----------
    values : floats
        PSNR of each picture, dB; inf counts as MSE 0, NaN is left out.

    Returns
    -------
    float
        dB; NaN when no value is left.
    """
    decibels = np.asarray(values, dtype=np.float64)
    decibels = decibels[~np.isnan(decibels)]
    if decibels.size == 0:
        return math.nan
    return psnr_db(float(np.mean(10.0 ** (-decibels / 10.0))), data_range=1.0)


def ssim(picture: NDArray[np.uint8], target: Target, data_range: float = 255.0) -> float:
    """Mean structural similarity, −1…1."""
    return structural_similarity(picture, target.picture, target.moments, data_range)


def evaluate(
    picture: NDArray[np.uint8],
    target: NDArray[np.uint8] | Target,
    mask: NDArray[np.bool_],
    data_range: float = 255.0,
) -> RestorationScores:
    """Score one repaired picture.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        The repaired picture.
    target : (H, W, 3) uint8 or Target
        The picture to reach. Give a ``Target`` when several filters are scored against it.
    mask : (H, W) bool
        The true mask.
    data_range : float
        Largest minus smallest possible value.

    Raises
    ------
    BenchError
        When the three do not fit together; see ``validate``.
    """
    goal = target if isinstance(target, Target) else Target(target)
    validate(picture, goal, mask, data_range)
    affected = int(np.count_nonzero(mask))
    # sums of squared grey levels are integers; OpenCV squares a root of them, rounding undoes that
    squared = round(cv2.norm(picture, goal.picture, cv2.NORM_L2SQR))
    squared_in_mask = round(cv2.norm(picture, goal.picture, cv2.NORM_L2SQR, mask.view(np.uint8)))
    mse_in_mask = squared_in_mask / (3 * affected) if affected else math.nan
    return RestorationScores(
        psnr_db=psnr_db(squared / picture.size, data_range),
        ssim=ssim(picture, goal, data_range),
        psnr_in_mask_db=psnr_db(mse_in_mask, data_range),
    )


def _check_picture(role: str, picture: NDArray[np.uint8]) -> None:
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise BenchError(
            f"restoration metrics: the {role} picture is {picture.dtype} {picture.shape}; "
            "give (H, W, 3) uint8"
        )
    if min(picture.shape[:2]) < WINDOW:
        raise BenchError(
            f"restoration metrics: the {role} picture is {picture.shape[:2]}; "
            f"SSIM needs at least {WINDOW} × {WINDOW} pixels"
        )
