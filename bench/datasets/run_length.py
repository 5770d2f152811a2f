"""Masks as COCO's compressed run-length encoding (``maskApi.c`` of pycocotools)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_DIGITS = 7
"""Of 5 bits each, more than a run in a picture of 2³² pixels takes."""


def runs(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Lengths of the runs of a mask read column by column, the first of them a run of False (maybe 0 long).

    Parameters
    ----------
    mask : (H, W) bool
    """
    flat = mask.ravel(order="F")
    changes = np.flatnonzero(np.diff(flat, prepend=False))
    return np.diff(changes, prepend=0, append=flat.size)


def compress(lengths: NDArray[np.int64]) -> str:
    """Text of the runs: from the fourth on the difference to the run two before, in digits of 5 bits from the
    lowest, bit 6 set where another follows, and 48 added to make it printable.
    """
    values = lengths.copy()
    values[3:] -= lengths[1:-2]
    places = 5 * np.arange(_DIGITS)
    digits = (values[:, None] >> places) & 31
    rest = values[:, None] >> (places + 5)
    # the last digit is the first one whose sign bit says all that is left
    last = np.argmax(rest == np.where(digits & 16, -1, 0), axis=1)
    more = np.arange(_DIGITS) < last[:, None]
    characters = (digits | np.where(more, 32, 0)) + 48
    return bytes(characters[np.arange(_DIGITS) <= last[:, None]].astype(np.uint8)).decode("ascii")


def box(mask: NDArray[np.bool_]) -> list[int]:
    """``[x, y, width, height]`` of the True pixels; all 0 for an empty mask."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return [0, 0, 0, 0]
    y, x = int(rows[0]), int(columns[0])
    return [x, y, int(columns[-1]) - x + 1, int(rows[-1]) - y + 1]
