"""From a detector's mask to a filter's answer: what stands in the mask afterwards."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered

RADIUS = 3  # pixels around a point that Telea 2004 draws on; OpenCV's usual value
REPAIRS = ("inpaint", "none")


def check_repair(name: str, repair: str) -> None:
    """Refuse an unknown repair.

    Raises
    ------
    VslamError
        When ``repair`` is not in ``REPAIRS``.
    """
    if repair not in REPAIRS:
        raise VslamError(f"light filter {name!r}: repair {repair!r} is unknown; give {' or '.join(REPAIRS)}")


def detected(
    image: NDArray[np.uint8], mask: NDArray[np.bool_], score: NDArray[np.float32], repair: str
) -> Filtered:
    """Answer with a mask, repaired or not.

    Parameters
    ----------
    image : (H, W, 3) uint8
    mask : (H, W) bool
    score : (H, W) float32
    repair : str
        "inpaint": by the fast marching method of Telea 2004 (OpenCV), from what surrounds the mask; a mask
        without surroundings stays as it is. "none": the picture stays as it is.
    """
    if repair == "none" or not mask.any() or mask.all():
        return Filtered(image.copy(), mask, score)
    return Filtered(_inpainted(image, mask), mask, score)


def _inpainted(image: NDArray[np.uint8], mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    # of pictures one pixel high or wide OpenCV reads memory beside them: the border is repeated around all
    around = (1, 1, 1, 1, cv2.BORDER_REPLICATE)
    filled = cv2.inpaint(
        cv2.copyMakeBorder(image, *around),
        cv2.copyMakeBorder(mask.view(np.uint8), *around),
        RADIUS,
        cv2.INPAINT_TELEA,
    )
    return np.ascontiguousarray(filled[1:-1, 1:-1])
