"""The mask of pixels that light has spoiled, eq. 3-4, and where no highlight reaches."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vslam.filters.stages.dark_channel import square


def light_mask(dark: NDArray[np.uint8], threshold: int) -> NDArray[np.bool_]:
    """mask(x) = 1 if I_dark(x) > t*, else 0.

    Parameters
    ----------
    dark : (H, W) uint8
        The dark channel.
    threshold : int
        t*, 0…255.

    Returns
    -------
    (H, W) bool
        True = affected by light.
    """
    return dark > threshold


def highlight_free(mask: NDArray[np.bool_], patch: int) -> NDArray[np.bool_]:
    """Find the pixels in no patch that the mask calls affected.

    The minimum in eq. 3-2 shrinks a highlight by half a patch on each side. The ring that it cuts off is as
    bright as the rest, so it must not serve as an example of the surface: the mask is widened by the patch.

    Parameters
    ----------
    mask : (H, W) bool
        Eq. 3-4.
    patch : int
        Side of Ω, pixels.

    Returns
    -------
    (H, W) bool
    """
    widened = cv2.dilate(mask.view(np.uint8), square(patch))
    return np.asarray(widened == 0, dtype=np.bool_)
