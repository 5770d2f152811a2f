"""The mask of pixels that light has spoiled, eq. 3-4, and where no highlight reaches."""

from __future__ import annotations

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from vslam.filters.stages.srgb import READABLE_CODES


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


def highlight_free(mask: NDArray[np.bool_], patch: int, every: int = 1) -> NDArray[np.bool_]:
    """Find the pixels in no patch that the mask calls affected.

    The minimum in eq. 3-2 shrinks a highlight by half a patch on each side. The ring that it cuts off is as
    bright as the rest, so it must not serve as an example of the surface: the mask is widened by the patch.

    Parameters
    ----------
    mask : (H, W) bool
        Eq. 3-4.
    patch : int
        Side of Ω, pixels, odd.
    every : int
        Only every so many rows are asked for.

    Returns
    -------
    (⌈H / every⌉, W) bool
        Of the rows 0, ``every``, 2 ``every`` …
    """
    width = mask.shape[1]
    flat = np.ascontiguousarray(mask).reshape(-1).view(np.uint8)
    return np.asarray(_free_rows(flat, width, patch, every)).reshape(-1, width)


# loops of one line over slices of their own: these are what numba compiles to vector instructions


@njit
def _enter(affected, row):  # type: ignore[no-untyped-def]
    for x in range(row.size):
        affected[x] = np.uint16(affected[x] + row[x])


@njit
def _leave(affected, row):  # type: ignore[no-untyped-def]
    for x in range(row.size):
        affected[x] = np.uint16(affected[x] - row[x])


@njit
def _any(affected, result):  # type: ignore[no-untyped-def]
    for x in range(result.size):
        result[x] = affected[x] > 0


@njit
def _either(one, other, result):  # type: ignore[no-untyped-def]
    for x in range(result.size):
        result[x] = one[x] | other[x]


@njit
def _neither(one, other, result):  # type: ignore[no-untyped-def]
    for x in range(result.size):
        result[x] = (one[x] | other[x]) == 0


@njit(
    types.boolean[::1](READABLE_CODES, types.int64, types.int64, types.int64), error_model="numpy", cache=True
)
def _free_rows(mask, width, patch, every):  # type: ignore[no-untyped-def]
    rows, half = mask.size // width, patch // 2
    served = (rows + every - 1) // every
    free = np.empty(served * width, dtype=np.bool_)
    around = np.zeros(width + 2 * half, dtype=np.uint16)
    affected = around[half : half + width]  # in each column, among the rows of the patch
    near, wider = np.empty(around.size, dtype=np.uint8), np.empty(around.size, dtype=np.uint8)
    entered, left = 0, 0
    for k in range(served):
        while entered < min(k * every + half + 1, rows):
            _enter(affected, mask[entered * width : entered * width + width])
            entered += 1
        while left < k * every - half:
            _leave(affected, mask[left * width : left * width + width])
            left += 1
        _any(around, near)
        span = 1  # of the columns that each element of near stands for; doubling beats stepping
        while 2 * span <= patch:
            _either(near, near[span:], wider[: wider.size - span])
            near, wider = wider, near
            span *= 2
        _neither(near, near[patch - span :], free[k * width : k * width + width])
    return free
