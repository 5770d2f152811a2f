"""Mend a separation where it failed (Yamamoto & Nakazawa 2019, "General improvement method of specular
component separation using high-emphasis filter and similarity function", ITE Trans. MTA 7).

Where a separation is right, sharpening the picture or its two parts gives the same. Where it fails, an edge
stands in the diffuse part that the picture does not have: its sharpened diffuse part is larger than the
sharpened picture. Such a pixel gets the diffuse colour of the pixel nearby that looks most like it and
whose own separation holds.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

EMPHASIS = 10  # k of the high-emphasis filter, the paper's table 1
COLOUR_WEIGHT = 0.3  # ω of the similarity, table 1
ROUNDS = 5  # at most, table 1
CONVERGED = 0.2 / 255  # root mean square change of the diffuse part between rounds, table 1 in grey levels
LARGEST_WINDOW = 41
"""Pixels. The paper's window has as many pixels as the picture has specular ones, and so the time grows with
their square; beyond this size it is cut."""


def corrected(linear: NDArray[np.float32], diffuse: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mend a diffuse part.

    H is the identity plus k times what a 3 × 3 mean takes away. A pixel is wrong when H ∗ D exceeds H ∗ I in
    all three channels (all responses cut to 0…1). It takes D of the pixel q of the square window around it
    that makes Φ = ω |I(p) − I(q)|² + (1 − ω) |(H ∗ I)(q) − (H ∗ D)(q) − (H ∗ S)(q)|² smallest. The window
    is as wide as the root of the number of specular pixels, those above Otsu's threshold of S = I − D. This
    is repeated until D stays as it is.

    Parameters
    ----------
    linear, diffuse : (H, W, 3) float32
        The picture and its diffuse part by another method, 0…1.

    Returns
    -------
    (H, W, 3) float32
        0 … ``linear``.
    """
    linear = np.ascontiguousarray(linear)
    sharp = _emphasised(linear)
    planes = np.empty((4, *linear.shape[:2]), dtype=np.float32)
    planes[:3] = np.sqrt(np.float32(COLOUR_WEIGHT)) * np.moveaxis(linear, 2, 0)
    for _ in range(ROUNDS):
        specular = linear - diffuse
        sharp_diffuse = _emphasised(diffuse)
        mismatch = sharp - np.minimum(sharp_diffuse + _emphasised(specular), 1.0)
        reach = _reach(specular)
        if reach == 0:
            break
        planes[3] = (1.0 - COLOUR_WEIGHT) * np.einsum("ijk,ijk->ij", mismatch, mismatch)
        wrong = (sharp_diffuse > sharp).all(axis=2)
        better = np.minimum(_replaced(planes, diffuse, wrong, reach), linear)
        change = float(np.sqrt(np.mean(np.square(better - diffuse), dtype=np.float64)))
        diffuse = better
        if change < CONVERGED:
            break
    return diffuse


def _emphasised(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """H ∗ picture, cut to 0…1; the border mirrored."""
    mean = cv2.blur(picture, (3, 3), borderType=cv2.BORDER_REFLECT)
    sharp = cv2.addWeighted(picture, 1.0 + EMPHASIS, mean, -float(EMPHASIS), 0.0)
    return np.asarray(np.clip(sharp, 0.0, 1.0), dtype=np.float32)


def _reach(specular: NDArray[np.float32]) -> int:
    """How far the window reaches from its centre, pixels; 0 without specular pixels."""
    levels = np.rint(255.0 * specular[..., 0]).astype(np.uint8)
    threshold, _ = cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    count = int(np.count_nonzero(levels > threshold))
    return min(int(np.ceil(np.sqrt(count) / 2)), LARGEST_WINDOW // 2)


@njit("float32(float32[:, :, ::1], float32, float32, float32, int64, int64)", cache=True)
def _phi(planes, red, green, blue, row, column):  # type: ignore[no-untyped-def]
    """Φ, with ω in the colour planes already."""
    a, b, c = red - planes[0, row, column], green - planes[1, row, column], blue - planes[2, row, column]
    return planes[3, row, column] + (a * a + b * b + c * c)


# reassociation lets the compiler take the minimum of a row many pixels at a time; there is no NaN here
@njit(
    "float32(float32[:, :, ::1], float32, float32, float32, int64, int64, int64)",
    cache=True,
    fastmath={"reassoc", "nnan", "ninf", "nsz"},
)
def _least(planes, red, green, blue, row, first, last):  # type: ignore[no-untyped-def]
    """The smallest Φ of a part of a row."""
    least = np.float32(1e30)  # Φ is at most 6
    for x in range(first, last):
        phi = _phi(planes, red, green, blue, row, x)
        least = phi if phi < least else least
    return least


@njit("float32[:, :, ::1](float32[:, :, ::1], float32[:, :, ::1], boolean[:, ::1], int64)", cache=True)
def _replaced(planes, diffuse, wrong, reach):  # type: ignore[no-untyped-def]
    """D with wrong pixels replaced by those of smallest Φ; the planes are √ω I, channel by channel, and the
    penalty.
    """
    height, width = wrong.shape
    better = diffuse.copy()
    for row in range(height):
        for column in range(width):
            if not wrong[row, column]:
                continue
            red, green, blue = planes[0, row, column], planes[1, row, column], planes[2, row, column]
            first, last = max(column - reach, 0), min(column + reach + 1, width)
            best, at_row = np.float32(np.inf), row
            for y in range(max(row - reach, 0), min(row + reach + 1, height)):
                least = _least(planes, red, green, blue, y, first, last)
                if least < best:
                    best, at_row = least, y
            at_column, best = column, np.float32(np.inf)
            for x in range(first, last):
                phi = _phi(planes, red, green, blue, at_row, x)
                if phi < best:
                    best, at_column = phi, x
            for c in range(3):
                better[row, column, c] = diffuse[at_row, at_column, c]
    return better
