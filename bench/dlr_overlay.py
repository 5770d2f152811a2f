"""What the detector found, drawn into a recorded picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TRUE, FALSE, ROW = (0, 158, 115), (213, 94, 0), (240, 228, 66)
"""Okabe and Ito's bluish green, vermilion and yellow, RGB."""
ACROSS = 3


def draw(
    picture: NDArray[np.uint8], found: FloatArray, true: NDArray[np.bool_], rows: FloatArray
) -> NDArray[np.uint8]:
    """The picture with rings: thin yellow at annotated rows, green at true detections, red at the others.

    Parameters
    ----------
    picture : (288, 768, 3) uint8
        Shown with its rows doubled, as a PAL field has half of them.
    found, rows : (n, 2), (m, 2) float64
        Pixels.
    true : (n,) bool
    """
    tall = np.ascontiguousarray(np.repeat(picture, 2, axis=0))
    for u, v in rows[np.isfinite(rows).all(axis=1)]:
        cv2.circle(tall, (round(u), round(2 * v)), 16, ROW, 1, cv2.LINE_AA)
    for (u, v), yes in zip(found, true, strict=True):
        cv2.circle(tall, (round(u), round(2 * v)), 11, TRUE if yes else FALSE, 2, cv2.LINE_AA)
    return tall


def sheet(pictures: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Pictures of one size, three in a row, at half size."""
    small = [cv2.resize(p, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for p in pictures]
    small += [np.full_like(small[0], 255)] * (-len(small) % ACROSS)
    rows = [np.hstack(small[i : i + ACROSS]) for i in range(0, len(small), ACROSS)]
    return np.asarray(np.vstack(rows), dtype=np.uint8)
