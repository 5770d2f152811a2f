"""From a separation into diffuse and specular light to a filter's answer: mask, score and repaired
picture.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered

# linear between 4096 nodes: exact below 0.0031308, where sRGB is a straight line, and within 1e-5 above
_NODES = np.linspace(0.0, 1.0, 4097)
_ENCODED = np.where(_NODES <= 0.0031308, 12.92 * _NODES, 1.055 * _NODES ** (1 / 2.4) - 0.055).astype(
    np.float32
)


def separated(linear: NDArray[np.float32], diffuse: NDArray[np.float32], levels: float) -> Filtered:
    """Keep a separation where the specular part is seen.

    Every pixel of a noisy picture has some specular part. The mask holds those in which it changes the
    recorded, encoded value of any channel by at least ``levels``; the others stay as recorded.

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear light 0…1.
    diffuse : (H, W, 3) float32
        The diffuse part, 0…1.
    levels : float
        Grey levels of 255, sRGB.

    Returns
    -------
    Filtered
        In linear light, the largest encoded residue of the three channels as the score, 0…1.
    """
    image, mask, score = _separated(np.ascontiguousarray(linear), diffuse, _ENCODED, levels / 255.0)
    return Filtered(image, mask, score)


def check_levels(name: str, levels: float) -> None:
    """Refuse a residue that no picture reaches or that every pixel has.

    Raises
    ------
    VslamError
        When it is not in 0 … 255, without 0.
    """
    if not 0.0 < levels <= 255.0:
        raise VslamError(
            f"light filter {name!r}: residue {levels} is outside 0…255; give grey levels above 0"
        )


@njit("float32(float32, float32[::1])", cache=True)
def encoded(linear, table):  # type: ignore[no-untyped-def]
    """One sRGB value, 0…1, of linear light in 0…1."""
    position = linear * np.float32(table.size - 1)
    node = min(int(position), table.size - 2)
    return table[node] + (position - node) * (table[node + 1] - table[node])


@njit(
    "Tuple((float32[:, :, ::1], boolean[:, ::1], float32[:, ::1]))"
    "(Array(float32, 3, 'C', readonly=True), float32[:, :, ::1], float32[::1], float64)",
    cache=True,
)
def _separated(linear, diffuse, table, least):  # type: ignore[no-untyped-def]
    height, width = linear.shape[:2]
    image = np.empty((height, width, 3), dtype=np.float32)
    mask = np.zeros((height, width), dtype=np.bool_)
    score = np.zeros((height, width), dtype=np.float32)
    for row in range(height):
        for column in range(width):
            residue = np.float32(0.0)
            for c in range(3):
                before, after = linear[row, column, c], diffuse[row, column, c]
                if before != after:
                    residue = max(residue, abs(encoded(before, table) - encoded(after, table)))
            score[row, column] = min(residue, np.float32(1.0))
            mask[row, column] = residue >= least
            for c in range(3):
                image[row, column, c] = (
                    diffuse[row, column, c] if mask[row, column] else linear[row, column, c]
                )
    return image, mask, score
