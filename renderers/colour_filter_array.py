"""Colour filter arrays: which of the three channels each photosite of a sensor sees."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

NO_ARRAY = "none"
"""Every pixel sees all three channels, as behind a prism or on a picture reduced from finer photosites."""

CELLS: Mapping[str, tuple[int, int, int, int]] = MappingProxyType(
    {"RGGB": (0, 1, 1, 2), "BGGR": (2, 1, 1, 0), "GRBG": (1, 0, 2, 1), "GBRG": (1, 2, 0, 1)}
)
"""Bayer's arrays (US 3,971,065) by the letters of their 2 × 2 cell, read from the picture's upper left:
the channel of each site."""

ARRAYS = (NO_ARRAY, *CELLS)

Number = TypeVar("Number", np.float32, np.float64, np.uint8, np.uint16)


def sites(array: str) -> Iterator[tuple[tuple[slice, slice], int]]:
    """The four sites of the cell: the index of all their pixels in a picture, and their channel."""
    for k, channel in enumerate(CELLS[array]):
        yield (slice(k // 2, None, 2), slice(k % 2, None, 2)), channel


def behind_filters(array: str, planes: NDArray[Number]) -> NDArray[Number]:
    """What the photosites see of three colour planes.

    Parameters
    ----------
    array : str
        One of `ARRAYS`.
    planes : (H, W, 3)

    Returns
    -------
    (H, W) mosaic; the planes themselves without an array
    """
    if array == NO_ARRAY:
        return planes
    mosaic = np.empty(planes.shape[:2], planes.dtype)
    for where, channel in sites(array):
        mosaic[where] = planes[..., channel][where]
    return mosaic
